// Lines of text to and from another player over TCP. Never blocks: the frame polls the lines that arrive.
//
//   invite() ── a player joins ──┐
//                                ├── send ──> lines ──> poll
//   join() ───── tries again ────┘
//
// Every wait has a time limit: for the other player to join, and for a sign of life from one who has. The
// sign of life is an empty object, "{}". The link sends it if it has sent nothing for a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::game {

struct PeerSettings {
  std::chrono::milliseconds patience{60'000};  ///< for the other player to join or to answer
  std::chrono::milliseconds silence{10'000};   ///< a player silent for this long has left …
  std::chrono::milliseconds strange_silence{
      3'000};  ///< … and so has a connection to an invitation that has not sent anything yet
  std::chrono::milliseconds beat{1'000};  ///< between signs of life
  std::size_t most_line = 64 * 1024;      ///< bytes per line, including its end
  std::size_t most_waiting = 4096;        ///< unpolled lines; no more are read until some are polled
};

class PeerLink {
 public:
  /// Listens on a local address, where one player may join. A connection whose first line is not a JSON
  /// object is dropped, and listening continues. Port 0: any free port. kUnavailable if the address cannot be
  /// listened on.
  static Expected<std::unique_ptr<PeerLink>> invite(const std::string& address, std::uint16_t port,
                                                    PeerSettings settings = {});
  /// Connects, and tries again until the patience is over.
  static std::unique_ptr<PeerLink> join(std::string host, std::uint16_t port, PeerSettings settings = {});
  /// Takes at most a second to send what is left.
  ~PeerLink();
  PeerLink(const PeerLink&) = delete;
  PeerLink& operator=(const PeerLink&) = delete;

  void send(std::string line);  ///< without its line break
  /// The lines received since the last call, at most `most` of them.
  std::vector<std::string> poll(std::size_t most = std::numeric_limits<std::size_t>::max());
  /// Why nothing more will arrive, once all earlier lines have been polled; for people.
  std::optional<std::string> ended() const;
  std::uint16_t port() const;  ///< invite(): the port it listens on

 private:
  struct State;
  explicit PeerLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fracture::game
