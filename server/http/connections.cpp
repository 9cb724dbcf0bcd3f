#include "server/http/connections.hpp"

#include <algorithm>
#include <tuple>

namespace fracture::http {

Connections::Arrival Connections::add(const std::string& client, OfClient limit) {
  std::shared_ptr<Drainable> leaves;  // released after the unlock, because this may destroy the session
  const std::lock_guard lock(mutex_);
  const auto mine = clients_.try_emplace(client).first;
  Verdict verdict = Verdict::kWelcome;
  if (limit == OfClient::kLimited && mine->second.places >= most_of_client_)
    verdict = Verdict::kTooManyOfClient;
  else if (places_ >= most_ && !(leaves = make_room_for(mine, limit)))
    verdict = Verdict::kFull;
  const bool welcome = verdict == Verdict::kWelcome;
  if (!welcome && (told_ >= kMostTold || mine->second.told >= kMostToldOfClient)) {
    forget_if_gone(mine);
    return {verdict};
  }
  entries_.push_back({welcome ? Kind::kPlace : Kind::kTold, mine});
  count(entries_.back(), true);
  return {verdict, Place(*this, std::prev(entries_.end()))};
}

void Connections::enroll(Entries::iterator at, const std::shared_ptr<Drainable>& session) {
  const std::lock_guard lock(mutex_);
  at->session = session.get();
  at->alive = session;
}

bool Connections::move(Entries::iterator at, const std::string& client, OfClient limit) {
  const std::lock_guard lock(mutex_);
  if (at->kind != Kind::kPlace || at->client->first == client) return true;
  const auto to = clients_.try_emplace(client).first;
  if (limit == OfClient::kLimited && to->second.places >= most_of_client_) return false;
  const auto from = at->client;
  count(*at, false);
  at->client = to;
  count(*at, true);
  forget_if_gone(from);
  return true;
}

void Connections::remove(Entries::iterator at) {
  const std::lock_guard lock(mutex_);
  const auto client = at->client;
  count(*at, false);
  entries_.erase(at);
  forget_if_gone(client);
}

std::vector<std::shared_ptr<Drainable>> Connections::sessions() const {
  std::vector<std::shared_ptr<Drainable>> alive;  // released after the unlock, too
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_)
    if (auto pointer = entry.alive.lock()) alive.push_back(std::move(pointer));
  return alive;
}

/// Chooses the session that gives up its place. Prefers sessions that only wait for their client: from the
/// client with the most places, the one that has waited longest. Clients with at most kFew places count as
/// equal, so that the longest wait decides among them. If no session waits, chooses the latest busy one of
/// the client with the most places, provided that this client keeps at least as many places as the newcomer's
/// client then has. Never takes a place from a client with fewer places, and from the newcomer's own client
/// only if that is a proxy.
std::shared_ptr<Drainable> Connections::make_room_for(Clients::iterator client, OfClient limit) {
  if (leaving_ >= kMostLeaving) return nullptr;
  using Since = Drainable::Clock::time_point;
  const std::size_t before = client->second.places;
  Entry* chosen = nullptr;
  std::tuple<bool, std::size_t, Since::duration> best;
  for (Entry& entry : entries_) {
    if (entry.kind != Kind::kPlace || entry.alive.expired()) continue;
    const bool own = entry.client == client;
    const std::optional<Since> since = entry.session->waiting_since();
    const std::size_t places = std::max(entry.client->second.places, since ? kFew : 0);
    const bool may = own     ? since && limit == OfClient::kUnlimited
                     : since ? places >= before
                             : places > before + 1;
    if (!may) continue;
    // Busy sessions have equal times, so the last one in the list wins, which is the latest.
    const std::tuple candidate(since.has_value(), places,
                               since ? -since->time_since_epoch() : Since::duration(0));
    if (chosen && (since ? candidate <= best : candidate < best)) continue;
    best = candidate;
    chosen = &entry;
  }
  if (!chosen) return nullptr;
  std::shared_ptr<Drainable> session = chosen->alive.lock();
  if (!session) return nullptr;  // already closing
  session->give_way(std::get<0>(best) ? Drainable::Leave::kIfItWaits : Drainable::Leave::kAnyhow);
  count(*chosen, false);
  chosen->kind = Kind::kLeaving;
  count(*chosen, true);
  return session;
}

void Connections::count(const Entry& entry, bool open) {
  Held& of = entry.client->second;
  const auto add = [open](std::size_t& number) { open ? ++number : --number; };
  add(of.open);
  switch (entry.kind) {
    case Kind::kPlace:
      add(of.places);
      return add(places_);
    case Kind::kTold:
      add(of.told);
      return add(told_);
    case Kind::kLeaving:
      return add(leaving_);
  }
}

void Connections::forget_if_gone(Clients::iterator client) {
  if (client->second.open == 0) clients_.erase(client);
}

}  // namespace fracture::http
