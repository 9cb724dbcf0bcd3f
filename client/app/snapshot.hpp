// A game between two steps: everything a frame draws, shows as text or plays as sound. Immutable once
// published.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/effects/debris.hpp"
#include "client/game/moment.hpp"
#include "client/sound/soundscape.hpp"

namespace fracture::app {

struct Snapshot {
  /// Time to show it, in seconds. The clock follows the game and also advances over dropped steps.
  double due = 0;
  std::shared_ptr<const game::Moment> moment;
  std::shared_ptr<const effects::Debris> debris;
  std::vector<game::Game::Coming> coming;
  // Since the previous snapshot.
  std::vector<sound::Voice> voices;
  std::vector<std::string> notes;  ///< for the player, from posted commands
  // Shown in the panel.
  game::GameFigures figures;
  world::Census census;  ///< some steps old, because a census visits every corner of every piece
  world::Ledger ledger;
  double step_ms = 0;  ///< time of the last step
  std::shared_ptr<const std::string> last_glb;
  std::shared_ptr<const std::string> patterns;  ///< Game::patterns(); null if not yet received
  bool history_full = false;
  /// While a recording is replayed: its progress in percent. Until the replay ends, steps do not follow the
  /// clock.
  std::optional<int> played_again_percent;
};

}  // namespace fracture::app
