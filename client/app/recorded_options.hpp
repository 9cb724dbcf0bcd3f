// The header of a recorded game: how the game began.
#pragma once

#include "client/app/options.hpp"
#include "client/game/recording.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

/// The header of a recording of a game with these options in this scene.
nlohmann::json header_of(const Options& options, const scenes::Scene& scene);
/// The options, overridden by everything in the header. kBadJson if the header is malformed.
Expected<Options> with_header(Options options, const nlohmann::json& header);
/// Reads a recording and sets `options` to those it was played with. kFileAccess, kBadJson; kFileAccess also
/// if an output would overwrite the recording or one of its meshes.
Expected<std::shared_ptr<const game::Recording>> recording_for(Options& options, const std::string& path);
/// kBadParameter if the header's game was played in another scene, with other meshes, positions or materials.
Expected<void> check_scene(const nlohmann::json& header, const scenes::Scene& scene);
/// A recorder for a file with that header, or null if the path is empty. kFileAccess.
Expected<std::shared_ptr<game::Recorder>> recorder_for(const std::string& path, const nlohmann::json& header);

}  // namespace fracture::app
