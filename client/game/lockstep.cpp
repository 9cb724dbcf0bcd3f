#include "client/game/lockstep.hpp"

#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"

namespace fracture::game {
namespace {

using nlohmann::json;

constexpr const char* kLockstepFormat = "fracture-lockstep-1";
constexpr std::size_t kMostNotDue = 1000;  ///< events of the other player that are not due yet

void play(Game& game, const RecordedEvent& event) {
  if (event.kind == RecordedEvent::Kind::kThrow)
    game.throw_ball(event.from, event.velocity, {event.radius, event.density});
  else
    game.explode({event.from, event.impulse, event.radius});
}

}  // namespace

json lockstep_header(json header, unsigned answer_steps, unsigned delay) {
  header["format"] = kLockstepFormat;
  header["rules"] = kRules;
  header["answer_steps"] = answer_steps;
  header["delay"] = delay;
  return header;
}

Expected<json> read_lockstep_header(const std::string& line) {
  constexpr unsigned kMostSteps = 1200;
  json header = json::parse(line, nullptr, false);
  const auto bad = [](const std::string& why) { return fail(ErrorCode::kBadJson, why); };
  if (!header.is_object())
    return bad(
        "The other player's first line is not the header of a game. Is the other program a fracture-client?");
  if (header.contains("refused") && header["refused"].is_string())
    return fail(ErrorCode::kUnavailable,
                "The other player refused: " + printable(header["refused"].get<std::string>()));
  const auto member = [&](const char* name) { return header.value(name, json()); };
  if (member("format") != kLockstepFormat)
    return bad("The other player's game has the format " + printable(json_text(member("format"))) +
               ", but this game has \"" + kLockstepFormat +
               "\". Both players need the same version of the program.");
  if (member("rules") != kRules)
    return bad("The other player's game uses rules " + printable(json_text(member("rules"))) +
               ", but this game uses rules " + std::to_string(kRules) +
               ". Both players need the same version of the program.");
  for (const char* name : {"answer_steps", "delay"})
    if (!member(name).is_number_unsigned() || member(name) < 1 || member(name) > kMostSteps)
      return bad(std::string("The other player's ") + name + " must be 1 to " + std::to_string(kMostSteps) +
                 " steps, but it is " + printable(json_text(member(name))) + ".");
  return header;
}

Lockstep::Lockstep(Game& game, PeerLink& link, Seat seat, json header, json theirs,
                   std::chrono::milliseconds patience)
    : game_(game),
      link_(link),
      seat_(seat),
      header_(std::move(header)),
      delay_(header_.at("delay").get<unsigned>()),
      patience_(patience) {
  link_.send(json_text(header_));
  if (!theirs.is_null()) take_header(theirs);
}

void Lockstep::leave(const std::string& why) {
  if (!trouble_) link_.send(json_text(json{{"refused", why}}));
  end(why);
}

void Lockstep::take_header(const json& theirs) {
  for (const auto& [name, value] : header_.items())
    if (!theirs.contains(name) || theirs[name] != value)
      return leave("The players' games differ in " + name + ": " + printable(json_text(value)) + " here, " +
                   (theirs.contains(name) ? printable(json_text(theirs[name])) : "none") + " there.");
  met_ = true;
}

void Lockstep::throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball) {
  add({.kind = RecordedEvent::Kind::kThrow,
       .from = from,
       .velocity = velocity,
       .radius = ball.radius,
       .density = ball.density});
}

void Lockstep::explode(const world::Blast& blast) {
  add({.kind = RecordedEvent::Kind::kExplode,
       .from = blast.point,
       .radius = blast.radius,
       .impulse = blast.impulse});
}

void Lockstep::add(RecordedEvent event) {
  event.step = game_.world().steps() + delay_;
  link_.send(json_text(line_of(event)));
  mine_.push_back(std::move(event));
}

void Lockstep::take(const std::string& line) {
  if (!met_) {
    const Expected<json> header = read_lockstep_header(line);
    if (header) return take_header(*header);
    return header.error().code == ErrorCode::kUnavailable ? end(header.error().detail)
                                                          : leave(header.error().detail);
  }
  try {
    const json read = json::parse(line);
    if (const auto refused = read.find("refused"); refused != read.end())
      return end("The other player refused: " + printable(refused->get<std::string>()));
    if (const auto hash = read.find("hash"); hash != read.end()) {
      if (read.at("step").get<std::uint64_t>() != heard_)
        throw std::runtime_error("expected step " + std::to_string(heard_));
      their_hashes_[heard_] = hash_of(hash->get<std::string>());
      ++heard_;
      return;
    }
    RecordedEvent event = event_of(read);
    if (event.kind != RecordedEvent::Kind::kThrow && event.kind != RecordedEvent::Kind::kExplode)
      throw std::runtime_error("a player can only send throws and explosions");
    if (event.step != heard_ + delay_)
      throw std::runtime_error("expected step " + std::to_string(heard_ + delay_));
    if (theirs_.size() >= kMostNotDue)
      throw std::runtime_error("more than " + std::to_string(kMostNotDue) + " throws and explosions at once");
    theirs_.push_back(std::move(event));
  } catch (const std::exception& error) {
    constexpr std::size_t kShown = 200;
    leave("A line from the other player is invalid (" + printable(json_trouble(error)) +
          "): " + printable(line.substr(0, kShown)));
  }
}

void Lockstep::compare() {
  while (!my_hashes_.empty() && !their_hashes_.empty() && !diverged_) {
    const auto mine = my_hashes_.begin(), theirs = their_hashes_.begin();
    if (mine->second != theirs->second) {
      diverged_ = mine->first;
      return leave("Step " + std::to_string(*diverged_) +
                   " differs between the two machines, so the game ends." +
                   (game_.figures().last_trouble.empty() ? "" : " " + game_.figures().last_trouble));
    }
    my_hashes_.erase(mine);
    their_hashes_.erase(theirs);
  }
}

void Lockstep::poll() {
  for (const std::string& line : link_.poll())
    if (!trouble_) take(line);
  compare();
}

bool Lockstep::ready() {
  poll();
  if (trouble_) return false;
  if (may_play()) {
    waits_since_.reset();
    return game_.ready();
  }
  wait_on();
  return false;
}

/// Waits for the other player, because no further step can be played.
void Lockstep::wait_on() {
  if (const auto why = link_.ended()) return end(*why);
  const Clock::time_point now = Clock::now();
  if (!waits_since_ || waits_for_ != heard_) {
    waits_since_ = now;
    waits_for_ = heard_;
  }
  if (met_ && now - *waits_since_ > patience_)
    leave("The other player is connected, but has not played a step for " +
          std::to_string(std::chrono::duration_cast<std::chrono::seconds>(patience_).count()) + " s.");
}

void Lockstep::step() {
  const std::uint64_t step = game_.world().steps();
  for (std::deque<RecordedEvent>* events :
       {seat_ == Seat::kHost ? &mine_ : &theirs_, seat_ == Seat::kHost ? &theirs_ : &mine_})
    for (; !events->empty() && events->front().step <= step; events->pop_front())
      play(game_, events->front());
  game_.step();
  const std::uint64_t fingerprint = game_.world().fingerprint();
  my_hashes_[step] = fingerprint;
  link_.send(hash_line(step, fingerprint));
  compare();
}

bool Lockstep::level() {
  poll();
  if (trouble_) return false;
  if (met_ && heard_ >= game_.world().steps()) return true;
  wait_on();
  return false;
}

}  // namespace fracture::game
