// What a recorded game says of how it began.
#pragma once

#include "client/app/options.hpp"
#include "client/game/recording.hpp"

namespace fracture::app {

/// The header of a recording of a game with these options.
nlohmann::json header_of(const Options& options);
/// The options with everything that the header says. kBadJson where it says it wrongly.
Expected<Options> with_header(Options options, const nlohmann::json& header);
/// A recorder for options.log; null without one. kFileAccess.
Expected<std::shared_ptr<game::Recorder>> recorder_for(const Options& options);

}  // namespace fracture::app
