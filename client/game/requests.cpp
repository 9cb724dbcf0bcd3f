// Decides what to request from the server, and which of several hits comes next.
#include <algorithm>

#include "client/game/game.hpp"

namespace fracture::game {

namespace {

/// Whether to state in the first request that hits will follow. The server then keeps what later hits start
/// from, so the first hit takes no longer than the next. Objects in fragments from the start never get such
/// hits.
bool takes_hits_later(const scenes::SceneObject& object, const nlohmann::json& parameters) {
  return !object.at_start && !parameters.contains("delta") && scenes::takes_hits(parameters);
}

}  // namespace

void Game::ask(const Waiting& hit) {
  const Thing& thing = things_[hit.thing];
  const scenes::SceneObject& object = scene_.objects[thing.scene_object];
  Pending pending;
  pending.thing = hit.thing;
  pending.fragment = hit.fragment;
  pending.asked_at = world_.steps();
  pending.ahead = hit.ahead;
  pending.due = world_.steps() + settings_.fixed_latency.value_or(0);
  ++asked_;
  ++figures_.requests;
  nlohmann::json body;
  if (hit.again) {
    const scenes::LocalHit local = scenes::local_hit(object, hit.impact);
    pending.before = thing.fragments;
    pending.by_name = true;
    pending.parameters = scenes::with_hit(thing.parameters, local);
    pending.wanted = pending.parameters;
    pending.wanted.update({{"delta", "only"}, {"local_new", 1}});
    body = scenes::hit_parameters(thing.fragments->location, local);
  } else if (hit.fragment) {
    // The server finds the fragment in the answer to the same parameters, which it still knows.
    body = thing.parameters;
    const auto& set = world::fragments_of(*thing.fragments->fragments);
    body["fragment"] = set.fragments[*hit.fragment].id;
    body["fragment_sites"] = 8;
    body["fragment_seed"] = settings_.seed + asked_;
    pending.parameters = pending.wanted = body;
  } else {
    body = scenes::fracture_parameters(object, hit.impact, settings_.seed + asked_, settings_.overrides);
    pending.parameters = body;
    // A falling thing breaks apart and leaves nothing that a ball could hit again.
    if (world_.stands(thing.id) && takes_hits_later(object, body)) body["delta"] = "stated";
    pending.wanted = body;
  }
  if (settings_.answers)
    pending.decoded = settings_.answers->find(thing.mesh, pending.wanted, pending.before);
  if (!pending.decoded) pending.ticket = client_.fracture(thing.mesh, body);
  pending_.emplace(asked_, std::move(pending));
}

void Game::ask_by_parameters(Pending& pending) {
  pending.by_name = false;
  pending.ticket = client_.fracture(things_[pending.thing].mesh, pending.wanted);
}

bool Game::wants_again(const Thing& thing, const world::Event& event) const {
  const scenes::SceneObject& object = scene_.objects[thing.scene_object];
  // A thing that starts in fragments keeps the fragments it is built of.
  if (!thing.fragments || thing.secondary || object.at_start || thing.fragments->location.empty() ||
      !scenes::takes_hits(thing.parameters) || thing.hit_by.contains(event.ball))
    return false;
  const scenes::LocalHit hit = scenes::local_hit(object, event.impact);
  constexpr std::size_t kFiner = 2;  // times as many
  return kFiner * world_.bonded_within(thing.id, event.fragment, hit.point, hit.radius) <=
         static_cast<std::size_t>(hit.sites);
}

Game::Requests::iterator Game::request_of(protocol::Ticket ticket) {
  return std::find_if(pending_.begin(), pending_.end(),
                      [&](const auto& entry) { return entry.second.ticket == ticket; });
}

void Game::want(const Waiting& hit) {
  const auto same = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& other) {
    return other.thing == hit.thing && other.fragment == hit.fragment;
  });
  if (same == waiting_.end())
    waiting_.push_back(hit);
  else if (hit.urgency > same->urgency || (same->ahead && !hit.ahead))
    *same = hit;
}

std::size_t Game::open_requests() const {
  return static_cast<std::size_t>(std::count_if(pending_.begin(), pending_.end(),
                                                [](const auto& entry) { return !entry.second.finished(); }));
}

std::size_t Game::counted_requests() const {
  constexpr std::uint64_t kMoment = 24;  // steps
  return static_cast<std::size_t>(std::count_if(pending_.begin(), pending_.end(), [&](const auto& entry) {
    return !entry.second.ahead || world_.steps() < entry.second.asked_at + kMoment;
  }));
}

std::size_t Game::kept_answers() const {
  return static_cast<std::size_t>(std::count_if(pending_.begin(), pending_.end(), [&](const auto& entry) {
    return entry.second.decoded && is_kept(entry.second);
  }));
}

/// Fragments cost more than the whole in every step, so they replace it only when a hit has happened or is a
/// few steps away.
bool Game::is_kept(const Pending& pending) const {
  const world::ObjectId object = things_[pending.thing].id;
  return pending.ahead && world_.is_whole(object) && !world_.expects_hit(object);
}

void Game::ask_most_urgent() {
  std::size_t open = counted_requests();
  while (!waiting_.empty() && open < settings_.max_requests) {
    const auto next =
        std::max_element(waiting_.begin(), waiting_.end(),
                         [](const Waiting& a, const Waiting& b) { return a.urgency < b.urgency; });
    const Waiting hit = *next;
    waiting_.erase(next);
    ask(hit);
    ++open;
  }
}

}  // namespace fracture::game
