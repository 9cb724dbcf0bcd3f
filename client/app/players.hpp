// The other player of a game: --invite and --join.
#pragma once

#include "client/app/options.hpp"
#include "client/game/lockstep.hpp"

namespace fracture::app {

struct Players {
  std::unique_ptr<game::PeerLink> link;
  game::Lockstep::Seat seat = game::Lockstep::Seat::kHost;
  nlohmann::json header;  ///< of this player's game
  nlohmann::json theirs;  ///< the host's, where it has been read; else null
};

/// Listens, or joins and waits for the host's header; `options` become those that it says, and reproducible. A link of
/// null where nobody is played with. kUnavailable, kBadJson.
Expected<Players> meet(Options& options);
/// The scene that the options make: kBadParameter, which the other one is told, where it is not the host's.
Expected<void> agree(Players& players, const Options& options, const scenes::Scene& scene);

}  // namespace fracture::app
