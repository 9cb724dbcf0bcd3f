#include "client/app/break_figures.hpp"

#include <algorithm>

namespace fracture::app {
namespace {

using nlohmann::json;

json figures_of(std::vector<double> late_ms) {
  std::sort(late_ms.begin(), late_ms.end());
  const auto at = [&](double share) {
    return late_ms.empty()
               ? 0.0
               : late_ms[static_cast<std::size_t>(share * static_cast<double>(late_ms.size() - 1))];
  };
  return {{"count", late_ms.size()},
          {"on_time", std::count(late_ms.begin(), late_ms.end(), 0.0)},
          {"late_p50_ms", at(0.5)},
          {"late_p99_ms", at(0.99)},
          {"late_ms", late_ms}};
}

}  // namespace

json break_figures(const game::Game& game) {
  const double step_ms = 1e3 * game.world().settings().step;
  std::vector<double> all, by[4];
  for (const world::Break& broken : game.figures().breaks) {
    const double late = step_ms * static_cast<double>(broken.late);
    all.push_back(late);
    by[static_cast<std::size_t>(broken.cause)].push_back(late);
  }
  std::size_t fragmented = 0;
  for (const game::Thing& thing : game.things())
    fragmented +=
        thing.fragments && !thing.secondary && !game.scene().objects[thing.scene_object].at_start ? 1 : 0;
  json result = figures_of(std::move(all));
  result["cause"] = {{"ball", figures_of(std::move(by[0]))},
                     {"fall", figures_of(std::move(by[1]))},
                     {"piece", figures_of(std::move(by[2]))},
                     {"blast", figures_of(std::move(by[3]))}};
  result["waiting"] = game.open_requests() + game.waiting_requests();
  result["spare"] = game.kept_answers() + fragmented - std::min(fragmented, game.figures().breaks.size());
  return result;
}

}  // namespace fracture::app
