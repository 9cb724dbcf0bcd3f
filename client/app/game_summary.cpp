#include "client/app/game_summary.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "client/app/break_figures.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;

json vec3(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json ledger_of(const world::World& world) {
  const world::Ledger& ledger = world.ledger();
  json rest = nullptr;
  if (ledger.asleep_since)
    rest = world.settings().step *
           std::max(0.0, static_cast<double>(*ledger.asleep_since) -
                             static_cast<double>(std::max(ledger.last_swap, ledger.last_woken)));
  return {{"brought_j", ledger.brought},
          {"energy_j", ledger.energy},
          {"worst_gain", ledger.brought > 0 ? ledger.worst_gain / ledger.brought : 0},
          {"deepest_mm", 1e3 * ledger.deepest},
          {"asleep_after_s", rest}};
}

json fragments_of(const game::Game& game) {
  json list = json::array();
  std::vector<world::FragmentState> states;
  for (const game::Thing& thing : game.things()) {
    if (!thing.fragments) {
      const world::Pose pose = game.world().object_pose(thing.id);
      list.push_back({{"thing", thing.id},
                      {"position", vec3(pose.position)},
                      {"rotation", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}}});
      continue;
    }
    const world::FragmentSet& set = world::fragments_of(*thing.fragments->fragments);
    game.world().fragment_states(thing.id, states);
    for (std::size_t k = 0; k < states.size(); ++k) {
      if (!states[k].present) continue;
      const world::Pose& pose = states[k].asset_to_world;
      list.push_back({{"thing", thing.id},
                      {"fragment", set.fragments[k].id},
                      {"group", states[k].group},
                      {"position", vec3(pose.point(set.fragments[k].mass.center))},
                      {"rotation", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}}});
    }
  }
  return list;
}

}  // namespace

json summary(const game::Game& game, const protocol::Client& client, const Options& options) {
  const protocol::Status status = client.status();
  const world::Census census = game.world().census();
  const game::GameFigures& figures = game.figures();
  json stages = json::object();
  for (const protocol::StageTime& stage : status.last_stages) stages[stage.name] = stage.milliseconds;
  json swaps = json::array();
  for (const world::Swap& swap : game.swaps())
    swaps.push_back({{"step", swap.step},
                     {"object", swap.object},
                     {"fragments", swap.fragments},
                     {"groups", swap.groups},
                     {"broken_bonds", swap.broken_bonds},
                     {"held", swap.held},
                     {"mass", swap.before.mass},
                     {"linear_before", vec3(swap.before.linear)},
                     {"linear_after", vec3(swap.after.linear)},
                     {"angular_before", vec3(swap.before.angular)},
                     {"angular_after", vec3(swap.after.angular)}});
  char fingerprint[20];
  std::snprintf(fingerprint, sizeof fingerprint, "%016llx",
                static_cast<unsigned long long>(game.world().fingerprint()));
  return {{"scene", game.scene().name},
          {"seed", options.seed},
          {"steps", game.world().steps()},
          {"fingerprint", fingerprint},
          {"warnings", game.scene().warnings},
          {"server",
           {{"state", name(status.state)},
            {"trouble", status.last_trouble},
            {"answered", status.answered},
            {"failed", status.failed},
            {"retried", status.retried},
            {"connections", status.connections_made},
            {"p50_ms", status.p50_ms},
            {"p99_ms", status.p99_ms},
            {"stages_ms", stages}}},
          {"game",
           {{"requests", figures.requests},
            {"answers", figures.answers},
            {"failures", figures.failures},
            {"swaps", figures.swaps},
            {"secondary", figures.secondary},
            {"hits", {{"applied", figures.hits}, {"too_late", figures.too_late}}},
            {"held_polls", figures.held_steps},
            {"open_requests", game.open_requests()},
            {"meshes_stored", game.meshes_stored()},
            {"trouble", figures.last_trouble},
            {"diverged", figures.diverged ? json(*figures.diverged) : json()},
            {"worst_momentum_error", figures.worst_momentum_error}}},
          {"bodies",
           {{"all", census.bodies},
            {"moving", census.moving},
            {"whole", census.whole},
            {"groups", census.groups},
            {"fragments", census.fragments},
            {"bonds", census.bonds},
            {"balls", census.balls},
            {"faded", census.faded},
            {"fastest", census.fastest},
            {"lowest", census.lowest}}},
          {"breaks", break_figures(game)},
          {"ledger", ledger_of(game.world())},
          {"swaps", swaps},
          {"fragments", fragments_of(game)}};
}

nlohmann::json summary_of_frames(std::vector<double> times) {
  if (times.empty()) return json::object();
  const json in_order = times;
  const double worst = *std::max_element(times.begin(), times.end());
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  return {{"count", times.size()},
          {"median_ms", at(0.5)},
          {"p99_ms", at(0.99)},
          {"worst_ms", worst},
          {"each_ms", in_order}};
}

void FrameTimes::write_to(json& result) && {
  result["frames"] = summary_of_frames(std::move(all_));
  result["waiting_frames"] = summary_of_frames(std::move(waiting_));
  result["swap_frames"] = summary_of_frames(std::move(swapping_));
  result["waiting_frames"]["first"] = first_wait_;
  result["swap_frames"]["first"] = first_swap_;
}

}  // namespace fracture::app
