// The other player of a game: --invite and --join.
#pragma once

#include "client/app/options.hpp"
#include "client/game/lockstep.hpp"

namespace fracture::app {

struct Players {
  std::unique_ptr<game::PeerLink> link;
  game::Lockstep::Seat seat = game::Lockstep::Seat::kHost;
  nlohmann::json header;  ///< header of this player's game
  nlohmann::json theirs;  ///< the host's header if it has been read, else null
};

/// Listens, or joins and waits for the host's header. `options` become the host's, with fixed_step. The link
/// is null in a game for one player. Errors: kUnavailable, kBadJson.
Expected<Players> meet(Options& options);
/// Checks that the scene is the same as the host's. Otherwise tells the host and returns kBadParameter.
Expected<void> agree(Players& players, const Options& options, const scenes::Scene& scene);

}  // namespace fracture::app
