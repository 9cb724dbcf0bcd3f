// What a recorded game says of how it began.
#pragma once

#include "client/app/options.hpp"
#include "client/game/recording.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

/// The header of a recording of a game with these options in the scene that they make.
nlohmann::json header_of(const Options& options, const scenes::Scene& scene);
/// The options with everything that the header says. kBadJson where it says it wrongly.
Expected<Options> with_header(Options options, const nlohmann::json& header);
/// Reads a recording; `options` become those that it was played with. kFileAccess, kBadJson, and where these are written
/// to what it reads.
Expected<std::shared_ptr<const game::Recording>> recording_for(Options& options, const std::string& path);
/// kBadParameter where the header's game was played in another scene: its meshes, places or materials are not these.
Expected<void> check_scene(const nlohmann::json& header, const scenes::Scene& scene);
/// A recorder for a file with that header; null where the path is empty. kFileAccess.
Expected<std::shared_ptr<game::Recorder>> recorder_for(const std::string& path, const nlohmann::json& header);

}  // namespace fracture::app
