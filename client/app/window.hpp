// The game in a window: camera, controls, panel.
#pragma once

#include "client/app/options.hpp"

namespace fracture::app {

/// Until the window is closed. Exit code: 0, or 1 where there is no display or no OpenGL 3.3 (said on
/// stderr).
int run_window(const Options& options);

}  // namespace fracture::app
