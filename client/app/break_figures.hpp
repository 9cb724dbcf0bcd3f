// How many things broke in a game, and whether their fragments were there in time.
#pragma once

#include <nlohmann/json.hpp>

#include "client/game/game.hpp"

namespace fracture::app {

/// `count`, `on_time` (fragments before the hit that broke them), `late_p50_ms`, `late_p99_ms` (of all, on time: 0), the same for each
/// `cause` (`ball`, `fall`, `piece`) with every lateness, `waiting` requests, and how many things have fragments and are unbroken
/// (`spare`: asked for ahead, and not hit hard enough).
nlohmann::json break_figures(const game::Game& game);

}  // namespace fracture::app
