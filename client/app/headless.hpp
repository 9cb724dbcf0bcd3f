// A run without a window, for tests, pictures and measurements.
#pragma once

#include <nlohmann/json.hpp>

#include "client/app/options.hpp"
#include "client/scenes/scene.hpp"
#include "common/base/error.hpp"

namespace fracture::app {

/// The scene that the options ask for.
Expected<scenes::Scene> scene_of(const Options& options);

/// Runs the game and returns the summary (client/README.md lists its members). With --fixed-step, the
/// simulated clock waits for answers. Otherwise the game follows real time and nothing waits. Errors:
/// kNoGraphics or kGraphicsDriver if a picture is requested and OpenGL is not available; kFileAccess if a
/// file cannot be written.
Expected<nlohmann::json> run_headless(const Options& options);

}  // namespace fracture::app
