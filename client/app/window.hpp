// The game in a window: camera, controls, panel.
#pragma once

#include "client/app/options.hpp"

namespace fracture::app {

/// Runs until the window is closed. Returns the exit code 0. Without a display or OpenGL 3.3, prints the reason
/// on stderr and returns 1.
int run_window(const Options& options);

}  // namespace fracture::app
