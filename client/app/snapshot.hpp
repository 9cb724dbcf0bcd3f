// A game at a boundary of its steps, as far as a frame draws, says or plays of it. Nobody changes it once it is published.
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
  /// When it is to be seen, in seconds of a clock that runs with the game, and on while the game does not keep up.
  double due = 0;
  std::shared_ptr<const game::Moment> moment;
  std::shared_ptr<const effects::Debris> debris;
  std::vector<game::Game::Coming> coming;
  // Since the snapshot before.
  std::vector<sound::Voice> voices;
  std::vector<std::string> notes;  ///< of what was posted, for people
  // What the panel says.
  game::GameFigures figures;
  world::Census census;  ///< of some steps before: it looks at every corner of every piece
  world::Ledger ledger;
  double step_ms = 0;  ///< of the last step
  std::shared_ptr<const std::string> last_glb;
  std::shared_ptr<const std::string> patterns;  ///< Game::patterns(); null before
  bool history_full = false;
  /// While a recording is played: how much of it. No step is made for the clock until it has ended.
  std::optional<int> played_again_percent;
};

}  // namespace fracture::app
