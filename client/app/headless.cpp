#include "client/app/headless.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "client/headless/egl_context.hpp"
#include "client/render/frame_target.hpp"
#include "client/view/stage_view.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kStepsPerFrame = 2;  // 120 steps and 60 frames a second

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

json vec3(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Pictures: a context and a renderer, made when the first is asked for.
class Camera {
 public:
  explicit Camera(const Options& options) : options_(options) {}

  Expected<json> take(const game::Game& game, const std::string& name) {
    constexpr int kStillSkyShadows = 32;  // pictures may take their time
    const Expected<view::ViewFigures> figures = draw(game, kStillSkyShadows);
    if (!figures) return tl::unexpected(figures.error());
    const std::string path = (std::filesystem::path(options_.out) / name).string();
    if (const auto written = write_png(target_->read(), path); !written)
      return tl::unexpected(written.error());
    return json{{"file", path},
                {"draw_calls", figures->draw_calls},
                {"shadow_draw_calls", figures->shadow_draw_calls},
                {"submit_ms", figures->submit_ms},
                {"culled", figures->culled}};
  }

  Expected<view::ViewFigures> draw(const game::Game& game,
                                   int sky_shadows = view::ViewSettings{}.sky_shadows) {
    if (auto ready = prepare(); !ready) return tl::unexpected(ready.error());
    const scenes::Stage& stage = game.stage();
    const float aspect = static_cast<float>(options_.width) / static_cast<float>(options_.height);
    view::ViewSettings settings;
    settings.sky_shadows = sky_shadows;
    const auto figures = view_->draw(game, view::look_at(stage.eye, stage.target, aspect), settings,
                                     target_->framebuffer(), options_.width, options_.height);
    if (!figures) return tl::unexpected(figures.error());
    return *figures;
  }

 private:
  Expected<void> prepare() {
    if (view_) return {};
    auto context = headless::EglContext::create();
    if (!context) return tl::unexpected(context.error());
    context_ = std::make_unique<headless::EglContext>(std::move(*context));
    auto target = render::FrameTarget::create(options_.width, options_.height);
    if (!target) return tl::unexpected(target.error());
    target_ = std::make_unique<render::FrameTarget>(std::move(*target));
    auto view = view::StageView::create();
    if (!view) return tl::unexpected(view.error());
    view_ = std::make_unique<view::StageView>(std::move(*view));
    return {};
  }

  const Options& options_;
  std::unique_ptr<headless::EglContext> context_;
  std::unique_ptr<render::FrameTarget> target_;
  std::unique_ptr<view::StageView> view_;
};

json summary_of_frames(std::vector<double> times) {
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

json summary(const game::Game& game, const protocol::Client& client, const Options& options) {
  const protocol::Status status = client.status();
  const world::Census census = game.world().census();
  const game::GameFigures& figures = game.figures();
  json stages = json::object();
  for (const protocol::Stage& stage : status.last_stages) stages[stage.name] = stage.milliseconds;
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
  return {{"scene", game.stage().name},
          {"seed", options.seed},
          {"steps", game.world().steps()},
          {"fingerprint", fingerprint},
          {"warnings", game.stage().warnings},
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
            {"held_polls", figures.held_steps},
            {"open_requests", game.open_requests()},
            {"meshes_stored", game.meshes_stored()},
            {"trouble", figures.last_trouble},
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
          {"swaps", swaps},
          {"fragments", fragments_of(game)}};
}

}  // namespace

Expected<scenes::Stage> stage_of(const Options& options) {
  Expected<scenes::Stage> stage =
      options.files.empty() ? scenes::make_stage(options.scene) : scenes::stage_of_files(options.files);
  if (stage && !options.material.empty()) set_material(*stage, options.material);
  return stage;
}

Expected<json> run_headless(const Options& options) {
  Expected<scenes::Stage> stage = stage_of(options);
  if (!stage) return tl::unexpected(stage.error());
  if (!options.throws) stage->throws.clear();
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  protocol::Client client(options.server);
  game::GameSettings settings;
  settings.seed = options.seed;
  settings.anticipate = options.anticipate;
  if (options.fixed_step) settings.fixed_latency = options.answer_steps;
  if (!options.requests) settings.max_requests = 0;
  game::Game game(std::move(*stage), client, settings);
  Camera camera(options);

  std::vector<double> wanted = options.screenshots, frame_times, submit_times, swap_frame_times,
                      waiting_times;
  std::size_t most_draw_calls = 0, first_swap = 0, first_wait = 0;
  std::sort(wanted.begin(), wanted.end());
  json pictures = json::array();
  double fastest = 0, fastest_ball = 0;
  const double frame_length = kStepsPerFrame * settings.world.step;
  const auto frames = static_cast<std::uint64_t>(std::llround(options.seconds / frame_length));
  std::size_t next_picture = 0, next_throw = 0;
  if (options.draw)  // compiles shaders and uploads the scene, which is no frame's work
    if (const auto drawn = camera.draw(game); !drawn) return tl::unexpected(drawn.error());
  const Clock::time_point start = Clock::now();
  for (std::uint64_t frame = 0; frame <= frames; ++frame) {
    const double now = static_cast<double>(frame) * frame_length;
    for (; next_picture < wanted.size() && wanted[next_picture] <= now + 1e-9; ++next_picture) {
      char file[64];
      std::snprintf(file, sizeof file, "%s-%.2f.png", game.stage().name.c_str(), wanted[next_picture]);
      Expected<json> picture = camera.take(game, file);
      if (!picture) return tl::unexpected(picture.error());
      (*picture)["seconds"] = wanted[next_picture];
      pictures.push_back(std::move(*picture));
    }
    if (options.record) {
      char file[64];
      std::snprintf(file, sizeof file, "frame-%05llu.png", static_cast<unsigned long long>(frame));
      if (Expected<json> picture = camera.take(game, file); !picture) return tl::unexpected(picture.error());
    }
    if (frame == frames) break;
    double spent = 0;
    const std::uint64_t swaps_before = game.figures().swaps;
    if (options.fixed_step) {
      for (int k = 0; k < kStepsPerFrame; ++k) {
        while (!game.ready()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        const Clock::time_point begin = Clock::now();
        game.step();
        spent += milliseconds_since(begin);
      }
    } else {
      for (; next_throw < game.stage().throws.size() && game.stage().throws[next_throw].time <= now + 1e-9;
           ++next_throw)
        game.throw_ball(game.stage().throws[next_throw].from, game.stage().throws[next_throw].velocity);
      const Clock::time_point begin = Clock::now();
      game.advance(frame_length, true);
      spent = milliseconds_since(begin);
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(now + frame_length)));
    }
    if (options.draw) {
      const auto drawn = camera.draw(game);
      if (!drawn) return tl::unexpected(drawn.error());
      submit_times.push_back(drawn->submit_ms);
      most_draw_calls = std::max(most_draw_calls, drawn->draw_calls);
      spent += drawn->submit_ms;
    }
    frame_times.push_back(spent);
    if (game.figures().swaps > swaps_before) {
      if (swap_frame_times.empty()) first_swap = frame_times.size() - 1;
      swap_frame_times.push_back(spent);
    } else if (game.open_requests() > 0) {
      if (waiting_times.empty()) first_wait = frame_times.size() - 1;
      waiting_times.push_back(spent);
    }
    fastest = std::max(fastest, game.world().census().fastest);
  }
  for (const scenes::Throw& thrown : game.stage().throws)
    fastest_ball = std::max(fastest_ball, glm::length(thrown.velocity));
  json result = summary(game, client, options);
  result["pictures"] = pictures;
  result["frames"] = summary_of_frames(std::move(frame_times));
  result["waiting_frames"] = summary_of_frames(std::move(waiting_times));
  result["swap_frames"] = summary_of_frames(std::move(swap_frame_times));
  result["waiting_frames"]["first"] = first_wait;
  result["swap_frames"]["first"] = first_swap;
  if (options.draw) {
    result["submit"] = summary_of_frames(std::move(submit_times));
    result["submit"]["most_draw_calls"] = most_draw_calls;
  }
  result["fastest_fragment"] = fastest;
  result["fastest_ball"] = fastest_ball;
  return result;
}

}  // namespace fracture::app
