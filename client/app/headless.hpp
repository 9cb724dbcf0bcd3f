// A run without a window: for tests, for pictures, for figures.
#pragma once

#include <nlohmann/json.hpp>

#include "client/app/options.hpp"
#include "client/scenes/scene.hpp"
#include "common/base/error.hpp"

namespace fracture::app {

/// The scene that the options ask for.
Expected<scenes::Scene> scene_of(const Options& options);

/// Runs it and returns the summary (client/README.md lists its members). With --fixed-step the simulated
/// clock waits for answers, else it is that of the wall and nothing waits. kNoGraphics or kGraphicsDriver where
/// a picture is asked for and there is no OpenGL for it, kFileAccess where it cannot be written.
Expected<nlohmann::json> run_headless(const Options& options);

}  // namespace fracture::app
