#include "client/game/game.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace fracture::game {

using protocol::Answer;
using protocol::RequestKind;

Game::Game(scenes::Scene scene, protocol::Client& client, GameSettings settings)
    : scene_(std::move(scene)),
      client_(client),
      settings_(std::move(settings)),
      world_(settings_.world),
      eye_(scene_.eye) {
  struct Stored {
    std::string id;
    protocol::Ticket ticket = 0;
  };
  std::map<std::pair<const scenes::MeshAsset*, std::string>, Stored> stored;  // by mesh and preparation
  for (std::size_t k = 0; k < scene_.objects.size(); ++k) {
    const scenes::SceneObject& object = scene_.objects[k];
    world::ObjectSpec spec;
    spec.hulls = object.mesh->hulls;
    spec.mass = object.mesh->unit_mass;
    spec.mass.mass *= object.density;
    spec.mass.inertia *= object.density;
    spec.pose = object.pose;
    spec.held = object.held;
    spec.strength = object.strength;
    spec.reach = object.reach;
    spec.crack_front = object.crack_front;
    spec.friction = object.friction;
    spec.restitution = object.restitution;
    Thing thing;
    thing.id = world_.add_object(spec);
    thing.scene_object = k;
    const std::string query = scenes::preparation_query(object, settings_.overrides);
    auto [known, is_new] = stored.try_emplace({object.mesh.get(), query});
    Stored& mesh = known->second;
    if (is_new)
      mesh.id = client_.add_mesh(object.mesh->bytes, object.mesh->content_type, query, &mesh.ticket);
    storing_[mesh.ticket].push_back(k);
    thing.mesh = mesh.id;
    things_.push_back(std::move(thing));
  }
  for (const scenes::SceneBox& box : scene_.boxes) world_.add_static_box(box.pose, box.half_sides);
  for (std::size_t k = 0; k < things_.size(); ++k)
    if (scene_.objects[k].at_start) ask({.thing = k});
}

Game::~Game() {
  for (const auto& [number, pending] : pending_) client_.cancel(pending.ticket);
}

std::size_t Game::thing_of(world::ObjectId object) const {
  const auto it =
      std::find_if(things_.begin(), things_.end(), [&](const Thing& thing) { return thing.id == object; });
  return static_cast<std::size_t>(it - things_.begin());
}

void Game::note_failure(Pending& pending, const std::string& what) {
  pending.failed = true;
  ++figures_.failures;
  figures_.last_trouble = what;
}

void Game::weigh(const std::vector<std::size_t>& things, const std::string& answer) {
  const nlohmann::json report = nlohmann::json::parse(answer, nullptr, false);
  // The unbroken thing must weigh as much as its fragments, and these count overlaps of parts once.
  const nlohmann::json::json_pointer path("/report/volume_once");
  if (!report.is_object() || !report.contains(path) || !report[path].is_number()) return;
  const double volume = report[path].get<double>();
  for (const std::size_t thing : things) {
    if (weighed_.contains(thing)) continue;
    const scenes::SceneObject& object = scene_.objects[things_[thing].scene_object];
    const double factor = volume / object.mesh->unit_mass.mass;
    if (factor > 0 && std::isfinite(factor) && factor != 1) scale_mass(thing, factor);
  }
}

void Game::scale_mass(std::size_t thing, double factor) {
  record({.step = world_.steps(), .kind = RecordedEvent::Kind::kMass, .thing = thing, .factor = factor});
  world_.scale_mass(things_[thing].id, factor);
  weighed_.insert(thing);
}

void Game::poll() {
  for (Answer& answer : client_.poll()) {
    if (answer.kind == RequestKind::kStore) {
      if (answer.ok())
        ++meshes_stored_;
      else
        figures_.last_trouble = "A mesh could not be stored on the server: " + answer.detail;
      if (const auto storing = storing_.find(answer.ticket); storing != storing_.end()) {
        if (answer.ok() && settings_.replay)
          to_weigh_.emplace_back(std::move(storing->second), std::move(answer.body));
        else if (answer.ok())
          weigh(storing->second, answer.body);
        storing_.erase(storing);
      }
    }
    if (answer.kind == RequestKind::kPatterns) {
      if (answer.ok())
        patterns_ = std::move(answer.body);
      else
        client_.patterns();  // not urgent, because the client has already retried
    }
    const auto it = request_of(answer.ticket);
    if (it == pending_.end()) continue;  // of an earlier game
    if (answer.ok()) {
      ++figures_.answers;
      it->second.milliseconds = answer.milliseconds;
      it->second.location = std::move(answer.location);
      decoder_.submit(answer.ticket, std::move(answer.body), it->second.before);
    } else if (answer.problem == "no-such-answer" && it->second.by_name) {
      ask_by_parameters(it->second);
    } else {
      note_failure(it->second, std::string(name(answer.failure)) + ": " + answer.detail);
    }
  }
  for (Decoded& decoded : decoder_.poll()) {
    const auto it = request_of(decoded.ticket);
    if (it == pending_.end()) continue;
    Pending& pending = it->second;
    if (!decoded.error.empty()) {
      note_failure(pending, "The server's answer cannot be used: " + decoded.error);
      continue;
    }
    decoded.location = std::move(pending.location);
    pending.decoded = std::make_shared<const Decoded>(std::move(decoded));
    if (settings_.answers)
      settings_.answers->keep(things_[pending.thing].mesh, pending.wanted, {pending.decoded, pending.before});
  }
}

void Game::apply(Pending& pending) {
  const std::size_t index = pending.thing;
  if (pending.failed) {
    if (!pending.fragment && !pending.before) world_.ask_again(things_[index].id);
    return;
  }
  if (pending.before) {
    apply_hit(pending);
    return;
  }
  last_glb_ = pending.decoded->glb;
  if (!pending.fragment) {
    if (!world_.is_whole(things_[index].id)) return;
    world_.fracture(things_[index].id, pending.decoded->fragments);
    things_[index].fragments = pending.decoded;
    const std::size_t count = world::fragments_of(*pending.decoded->fragments).fragments.size();
    char text[80];
    std::snprintf(text, sizeof text, ": %zu fragment%s, answered after %.0f ms", count, count == 1 ? "" : "s",
                  pending.milliseconds);
    figures_.last_break = scene_.objects[things_[index].scene_object].name + text;
    things_[index].parameters = std::move(pending.parameters);
  } else if (const auto id =
                 world_.fracture_fragment(things_[index].id, *pending.fragment, pending.decoded->fragments)) {
    Thing pieces;
    pieces.id = *id;
    pieces.scene_object = things_[index].scene_object;
    pieces.mesh = things_[index].mesh;
    pieces.fragments = pending.decoded;
    pieces.secondary = true;
    things_.push_back(std::move(pieces));
    ++figures_.secondary;
  }
  ++figures_.swaps;
}

void Game::apply_hit(Pending& pending) {
  Thing& thing = things_[pending.thing];
  if (!world_.change(thing.id, pending.decoded->fragments)) {
    ++figures_.too_late;
    return;
  }
  const std::size_t count = pending.decoded->layers.back().fragment_of_object.size();
  char text[80];
  std::snprintf(text, sizeof text, ": %zu new fragment%s, answered after %.0f ms", count,
                count == 1 ? "" : "s", pending.milliseconds);
  figures_.last_break = scene_.objects[thing.scene_object].name + text;
  thing.fragments = std::move(pending.decoded);
  thing.parameters = std::move(pending.parameters);
  ++figures_.hits;
  ++figures_.swaps;
}

bool Game::adopt(Requests::iterator it) {
  const bool swapped = !it->second.failed;
  record({.step = world_.steps(),
          .kind = swapped ? RecordedEvent::Kind::kAdopt : RecordedEvent::Kind::kFail,
          .request = it->first});
  apply(it->second);
  pending_.erase(it);
  return swapped;
}

bool Game::apply_due() {
  bool any = false;
  for (auto it = pending_.begin(); it != pending_.end();) {
    const auto next = std::next(it);
    const bool due = !settings_.fixed_latency || it->second.due <= world_.steps();
    if (due && it->second.finished() && (it->second.failed || !is_kept(it->second)) && adopt(it)) {
      any = true;
      if (!settings_.fixed_latency) break;  // one per frame, so that no frame is much longer
    }
    it = next;
  }
  return any;
}

void Game::record(const RecordedEvent& event) {
  if (settings_.recorder) settings_.recorder->add(event);
  if (settings_.history) settings_.history->add(event);
}

void Game::record_eye(std::uint64_t step) {
  if (!is_recorded() || recorded_eye_ == eye_) return;
  record({.step = step, .kind = RecordedEvent::Kind::kEye, .from = eye_});
  recorded_eye_ = eye_;
}

void Game::set_overrides(nlohmann::json overrides) {
  if (overrides == settings_.overrides) return;
  settings_.overrides = std::move(overrides);
  record({.step = world_.steps(), .kind = RecordedEvent::Kind::kOverrides, .overrides = settings_.overrides});
}

std::vector<Game::Coming> Game::coming() const {
  std::vector<Coming> list;
  for (const auto& [number, pending] : pending_)
    if (pending.decoded)
      list.push_back({pending.thing, things_[pending.thing].scene_object, pending.decoded});
  return list;
}

bool Game::ready() {
  poll();
  if (settings_.replay) {
    if (replay_is_ready()) return true;
    ++figures_.held_steps;
    return false;
  }
  if (!settings_.fixed_latency) return true;
  if (world_.steps() == 0 && !storing_.empty()) return false;  // masses must be known from the first step on
  const bool all = std::all_of(pending_.begin(), pending_.end(), [&](const auto& entry) {
    return entry.second.due > world_.steps() || entry.second.finished();
  });
  if (!all) ++figures_.held_steps;
  return all;
}

void Game::take_events() {
  for (const world::Event& event : world_.take_events()) {
    const bool again = event.kind == world::Event::Kind::kAgain;
    if ((again || event.kind == world::Event::Kind::kAhead) && !settings_.anticipate) continue;
    const std::size_t thing = thing_of(event.object);
    if (thing == things_.size()) continue;
    const bool fragment = event.kind == world::Event::Kind::kBreakFragment;
    if (fragment && things_[thing].secondary) continue;  // fragments break further only once
    // It was requested ahead and hit before the answer arrived.
    const bool asked = std::any_of(pending_.begin(), pending_.end(), [&](const auto& entry) {
      return entry.second.thing == thing && !entry.second.fragment;
    });
    if (!fragment && asked) continue;
    if (again && !wants_again(things_[thing], event)) continue;
    if (settings_.max_requests == 0) {
      if (!fragment && !again) world_.ask_again(event.object);
      continue;
    }
    record_eye(std::max<std::uint64_t>(world_.steps(), 1) - 1);  // hits belong to the step before
    if (again) things_[thing].hit_by.insert(event.ball);
    const glm::dvec3 away = event.where - eye_;
    want({thing, fragment ? std::optional(event.fragment) : std::nullopt, event.impact,
          event.impact.impulse / std::max(glm::dot(away, away), 0.25),
          event.kind == world::Event::Kind::kAhead, again});
  }
  ask_most_urgent();
  for (const world::Swap& swap : world_.take_swaps()) {
    if (!swap.held && swap.before.mass > 0) {
      const auto error = [](const glm::dvec3& a, const glm::dvec3& b, double scale) {
        return glm::distance(a, b) / std::max({glm::length(a), glm::length(b), scale});
      };
      // Relative to at least the momentum of the mass at 1 cm/s, or circling at 1 cm/s at a radius of 1 m,
      // because objects may be at rest.
      figures_.worst_momentum_error =
          std::max({figures_.worst_momentum_error,
                    error(swap.before.linear, swap.after.linear, 0.01 * swap.before.mass),
                    error(swap.before.angular, swap.after.angular, 0.01 * swap.before.mass)});
    }
    swaps_.push_back(swap);
  }
  for (const world::Break& broken : world_.take_breaks())
    if (const std::size_t thing = thing_of(broken.object);
        thing < things_.size() && !scene_.objects[things_[thing].scene_object].at_start)
      figures_.breaks.push_back(broken);
}

void Game::step() {
  if (settings_.replay) {
    play_recorded();
  } else if (settings_.fixed_latency) {
    apply_due();
    ask_most_urgent();  // finished requests make room now, as in a replay
    throw_scripted(static_cast<double>(world_.steps()) * settings_.world.step);
  }
  const std::uint64_t step = world_.steps();
  world_.step();
  if (is_recorded() || settings_.replay) {
    const std::uint64_t fingerprint = world_.fingerprint();
    if (settings_.recorder) settings_.recorder->add_hash(step, fingerprint);
    if (settings_.history) settings_.history->add_hash(fingerprint);
    if (settings_.replay && !figures_.diverged && step < settings_.replay->hashes.size() &&
        fingerprint != settings_.replay->hashes[step])
      figures_.diverged = step;
  }
  take_events();
}

void Game::throw_scripted(double until) {
  constexpr double kSameTime = 1e-9;  // seconds
  for (; next_throw_ < scene_.throws.size() && scene_.throws[next_throw_].time <= until + kSameTime;
       ++next_throw_)
    throw_ball(scene_.throws[next_throw_].from, scene_.throws[next_throw_].velocity);
  for (; next_blast_ < scene_.blasts.size() && scene_.blasts[next_blast_].time <= until + kSameTime;
       ++next_blast_)
    explode(scene_.blasts[next_blast_].blast);
}

bool Game::attend() {
  const bool swapped = apply_due();
  poll();
  take_events();
  return swapped;
}

void Game::advance(double seconds, bool running) {
  const bool swapped = attend();
  if (!running) {
    owed_ = 0;
    return;
  }
  // New pieces have only new contacts in their first step, which takes longer. So that step has the frame to
  // itself, and the rest of the frame's simulated time is dropped.
  const int most = swapped ? 1 : 6;
  owed_ += seconds;
  int steps = 0;
  while (owed_ >= settings_.world.step && steps < most) {
    step();
    owed_ -= settings_.world.step;
    ++steps;
  }
  if (steps == most) owed_ = 0;
}

std::string Game::material_of(world::ObjectId object) const {
  const std::size_t thing = thing_of(object);
  if (thing == things_.size()) return {};
  return scene_.objects[things_[thing].scene_object].breakage.parameters.value("material", "");
}

world::BallId Game::throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball) {
  record({.step = world_.steps(),
          .kind = RecordedEvent::Kind::kThrow,
          .from = from,
          .velocity = velocity,
          .radius = ball.radius,
          .density = ball.density});
  return world_.throw_ball(from, velocity, ball.radius > 0 ? ball.radius : scene_.ball_radius,
                           ball.density > 0 ? ball.density : scene_.ball_density);
}

void Game::explode(const world::Blast& blast) {
  record_eye(world_.steps());
  record({.step = world_.steps(),
          .kind = RecordedEvent::Kind::kExplode,
          .from = blast.point,
          .radius = blast.radius,
          .impulse = blast.impulse});
  world_.explode(blast);
  // Handled now, because the hits of the next step are handled after that step, when the eye may have moved.
  take_events();
}

}  // namespace fracture::game
