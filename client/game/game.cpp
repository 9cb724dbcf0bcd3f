#include "client/game/game.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace fracture::game {

using protocol::Answer;
using protocol::RequestKind;

Game::Game(scenes::Scene scene, protocol::Client& client, GameSettings settings)
    : scene_(std::move(scene)), client_(client), settings_(std::move(settings)), world_(settings_.world) {
  std::map<std::pair<const scenes::MeshAsset*, std::string>, std::string> stored;  // with how it is prepared
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
    const std::string query = scenes::preparation_query(object);
    auto [id, is_new] = stored.try_emplace({object.mesh.get(), query});
    if (is_new) id->second = client_.add_mesh(object.mesh->bytes, object.mesh->content_type, query);
    thing.mesh = id->second;
    things_.push_back(std::move(thing));
  }
  for (const scenes::SceneBox& box : scene_.boxes) world_.add_static_box(box.pose, box.half_sides);
  for (std::size_t k = 0; k < things_.size(); ++k)
    if (scene_.objects[k].at_start) ask(k, world::Impact{}, std::nullopt);
}

Game::~Game() {
  for (const auto& [ticket, pending] : pending_) client_.cancel(ticket);
}

std::size_t Game::thing_of(world::ObjectId object) const {
  const auto it =
      std::find_if(things_.begin(), things_.end(), [&](const Thing& thing) { return thing.id == object; });
  return static_cast<std::size_t>(it - things_.begin());
}

void Game::ask(std::size_t index, const world::Impact& impact, std::optional<std::uint32_t> fragment) {
  const Thing& thing = things_[index];
  const scenes::SceneObject& object = scene_.objects[thing.scene_object];
  Pending pending;
  pending.thing = index;
  pending.fragment = fragment;
  ++asked_;
  if (fragment) {
    // The server finds the fragment in the answer to the same parameters, which it still knows.
    pending.parameters = thing.parameters;
    const auto& set = world::fragments_of(*thing.fragments->fragments);
    pending.parameters["fragment"] = set.fragments[*fragment].id;
    pending.parameters["fragment_sites"] = 8;
    pending.parameters["fragment_seed"] = settings_.seed + asked_;
  } else {
    pending.parameters =
        scenes::fracture_parameters(object, impact, settings_.seed + asked_, settings_.overrides);
  }
  pending.due = world_.steps() + settings_.fixed_latency.value_or(0);
  ++figures_.requests;
  const protocol::Ticket ticket = client_.fracture(thing.mesh, pending.parameters);
  pending_.emplace(ticket, std::move(pending));
}

void Game::note_failure(Pending& pending, const std::string& what) {
  pending.failed = true;
  ++figures_.failures;
  figures_.last_trouble = what;
}

void Game::poll() {
  for (Answer& answer : client_.poll()) {
    if (answer.kind == RequestKind::kStore) {
      if (answer.ok())
        ++meshes_stored_;
      else
        figures_.last_trouble = "A mesh was not stored: " + answer.detail;
    }
    if (answer.kind == RequestKind::kPatterns) {
      if (answer.ok())
        patterns_ = std::move(answer.body);
      else
        client_.patterns();  // it took its patience: no hurry
    }
    const auto it = pending_.find(answer.ticket);
    if (it == pending_.end()) continue;  // of a game before this one
    if (answer.ok()) {
      ++figures_.answers;
      decoder_.submit(answer.ticket, std::move(answer.body));
    } else {
      note_failure(it->second, std::string(name(answer.failure)) + ": " + answer.detail);
    }
  }
  for (Decoded& decoded : decoder_.poll()) {
    const auto it = pending_.find(decoded.ticket);
    if (it == pending_.end()) continue;
    if (decoded.error.empty())
      it->second.decoded = std::make_shared<const Decoded>(std::move(decoded));
    else
      note_failure(it->second, "The answer cannot be used: " + decoded.error);
  }
}

void Game::apply(Pending& pending) {
  const std::size_t index = pending.thing;
  if (pending.failed) {
    if (!pending.fragment) world_.ask_again(things_[index].id);
    return;
  }
  last_glb_ = pending.decoded->glb;
  if (!pending.fragment) {
    if (!world_.is_whole(things_[index].id)) return;
    world_.fracture(things_[index].id, pending.decoded->fragments);
    things_[index].fragments = pending.decoded;
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

bool Game::apply_due() {
  bool any = false;
  for (auto it = pending_.begin(); it != pending_.end();) {
    const bool due = !settings_.fixed_latency || it->second.due <= world_.steps();
    if (!due || !it->second.finished()) {
      ++it;
      continue;
    }
    const bool swapped = !it->second.failed;
    apply(it->second);
    it = pending_.erase(it);
    any = any || swapped;
    if (swapped && !settings_.fixed_latency) break;  // one a frame: none is much longer than the others
  }
  return any;
}

std::vector<Game::Coming> Game::coming() const {
  std::vector<Coming> list;
  for (const auto& [ticket, pending] : pending_)
    if (pending.decoded) list.push_back({pending.thing, pending.decoded});
  return list;
}

bool Game::ready() {
  poll();
  if (!settings_.fixed_latency) return true;
  const bool all = std::all_of(pending_.begin(), pending_.end(), [&](const auto& entry) {
    return entry.second.due > world_.steps() || entry.second.finished();
  });
  if (!all) ++figures_.held_steps;
  return all;
}

void Game::take_events() {
  for (const world::Event& event : world_.take_events()) {
    if (event.kind == world::Event::Kind::kAhead && !settings_.anticipate) continue;
    const std::size_t thing = thing_of(event.object);
    if (thing == things_.size()) continue;
    const bool fragment = event.kind == world::Event::Kind::kBreakFragment;
    if (fragment && things_[thing].secondary) continue;  // once is enough
    // Anticipated, and hit before the answer came: it is on its way.
    const bool asked = std::any_of(pending_.begin(), pending_.end(), [&](const auto& entry) {
      return entry.second.thing == thing && !entry.second.fragment;
    });
    if (!fragment && asked) continue;
    if (pending_.size() >= settings_.max_requests) {
      if (!fragment) world_.ask_again(event.object);
      continue;
    }
    ask(thing, event.impact, fragment ? std::optional(event.fragment) : std::nullopt);
  }
  for (const world::Swap& swap : world_.take_swaps()) {
    if (!swap.held && swap.before.mass > 0) {
      const auto error = [](const glm::dvec3& a, const glm::dvec3& b, double scale) {
        return glm::distance(a, b) / std::max({glm::length(a), glm::length(b), scale});
      };
      // Against what the masses would have at 1 cm/s, or turning so at 1 m, where they rest.
      figures_.worst_momentum_error =
          std::max({figures_.worst_momentum_error,
                    error(swap.before.linear, swap.after.linear, 0.01 * swap.before.mass),
                    error(swap.before.angular, swap.after.angular, 0.01 * swap.before.mass)});
    }
    swaps_.push_back(swap);
  }
}

void Game::step() {
  if (settings_.fixed_latency) apply_due();
  const double now = static_cast<double>(world_.steps()) * settings_.world.step;
  if (settings_.fixed_latency)
    while (next_throw_ < scene_.throws.size() && scene_.throws[next_throw_].time <= now + 1e-9) {
      throw_ball(scene_.throws[next_throw_].from, scene_.throws[next_throw_].velocity);
      ++next_throw_;
    }
  world_.step();
  take_events();
}

void Game::advance(double seconds, bool running) {
  const bool swapped = apply_due();
  poll();
  take_events();
  if (!running) {
    owed_ = 0;
    return;
  }
  // All contacts of new pieces are new in their first step, which takes longer: it has its frame to itself,
  // and simulated time falls behind by the rest of that frame.
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

world::BallId Game::throw_ball(const glm::dvec3& from, const glm::dvec3& velocity) {
  return world_.throw_ball(from, velocity, scene_.ball_radius, scene_.ball_density);
}

}  // namespace fracture::game
