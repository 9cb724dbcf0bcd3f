// The game in a window: camera, controls, panel.
#pragma once

#include "client/app/options.hpp"

namespace fracture::app {

/// Runs until the window is closed. Returns the exit code: 0, or 1 if there is no display or no OpenGL 3.3 (explained on
/// stderr).
int run_window(const Options& options);

}  // namespace fracture::app
