#include "client/app/players.hpp"

#include <cstdio>
#include <thread>

#include "client/app/recorded_options.hpp"
#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;

/// Waits for the first line. This needs no time limit, because the link ends every wait.
Expected<std::string> first_line(game::PeerLink& link) {
  while (true) {
    const std::optional<std::string> why = link.ended();
    if (std::vector<std::string> lines = link.poll(1); !lines.empty()) return std::move(lines.front());
    if (why) return fail(ErrorCode::kUnavailable, *why);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void refuse(game::PeerLink& link, const std::string& why) { link.send(json_text(json{{"refused", why}})); }

/// Replaces the options of the command line by those of the host.
Expected<Options> as_host(Options options, const json& header) {
  Expected<Options> begun = with_header(std::move(options), header);
  if (!begun) return begun;
  if (!begun->files.empty())
    return fail(
        ErrorCode::kBadParameter,
        "The host plays with its own meshes. Such a game cannot be joined; the host must choose a scene.");
  for (const auto& [name, value] :
       {std::pair("throws", &begun->throws), std::pair("requests", &begun->requests)}) {
    const json said = header.value(name, json());
    if (!said.is_boolean())
      return fail(ErrorCode::kBadJson,
                  std::string("In the header of the host's game, '") + name + "' must be true or false.");
    *value = said.get<bool>();
  }
  const json seconds = header.value("seconds", json());
  constexpr double kMostSeconds = 3600;
  if (!seconds.is_number() || !(seconds >= 0) || !(seconds <= kMostSeconds))
    return fail(ErrorCode::kBadJson,
                "In the header of the host's game, 'seconds' must be a number from 0 to 3600.");
  begun->seconds = seconds.get<double>();
  begun->answer_steps = header.at("answer_steps").get<unsigned>();
  return begun;
}

}  // namespace

Expected<Players> meet(Options& options) {
  Players players;
  if (options.invite.port != 0) {
    auto link = game::PeerLink::invite(options.invite.host, options.invite.port);
    if (!link) return tl::unexpected(link.error());
    players.link = std::move(*link);
    std::fprintf(stderr, "fracture-client: waiting for another player at %s:%d\n",
                 options.invite.host.c_str(), static_cast<int>(options.invite.port));
  } else if (options.join.port != 0) {
    players.seat = game::Lockstep::Seat::kGuest;
    players.link = game::PeerLink::join(options.join.host, options.join.port);
    std::fprintf(stderr, "fracture-client: looking for another player at %s:%d\n",
                 printable(options.join.host).c_str(), static_cast<int>(options.join.port));
    const Expected<std::string> line = first_line(*players.link);
    if (!line) return tl::unexpected(line.error());
    Expected<json> header = game::read_lockstep_header(*line);
    Expected<Options> begun = header ? as_host(options, *header) : tl::unexpected(header.error());
    if (!begun) {
      refuse(*players.link, begun.error().detail);
      return tl::unexpected(begun.error());
    }
    options = std::move(*begun);
    players.theirs = std::move(*header);
  } else {
    return players;
  }
  options.fixed_step = true;
  return players;
}

Expected<void> agree(Players& players, const Options& options, const scenes::Scene& scene) {
  if (!players.link) return {};
  json header = header_of(options, scene);
  header["throws"] = options.throws;
  header["requests"] = options.requests;
  header["seconds"] = options.seconds;
  players.header = game::lockstep_header(std::move(header), options.answer_steps);
  if (players.theirs.is_null()) return {};
  players.header["delay"] = players.theirs.at("delay");
  const auto same = check_scene(players.theirs, scene);
  if (!same) refuse(*players.link, same.error().detail);
  return same;
}

}  // namespace fracture::app
