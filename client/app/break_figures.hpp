// Statistics on breaks: how many things broke, and how late their fragments were.
#pragma once

#include <nlohmann/json.hpp>

#include "client/game/game.hpp"

namespace fracture::app {

/// `count`: number of breaks. `on_time`: those whose fragments were there before the hit. `late_ms`: the
/// lateness of each. `late_p50_ms`, `late_p99_ms`: percentiles over all breaks; on time counts as 0. `cause`:
/// the same members for `ball`, `fall`, `piece` and `blast`. `waiting`: number of requests without an answer.
/// `spare`: unbroken things with fragments that were requested ahead.
nlohmann::json break_figures(const game::Game& game);

}  // namespace fracture::app
