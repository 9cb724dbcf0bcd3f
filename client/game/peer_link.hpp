// Lines of text to and from another player over TCP. Never waits: what comes is polled from the frame.
//
//   invite() ── one who joins ──┐
//                               ├── send ──> lines ──> poll
//   join() ──── tries again ────┘
//
// Every wait has an end: for the other to come, and for a sign of life of one who has. An empty object, "{}", is such a
// sign, which the link sends when it has sent nothing for a second.
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
  std::chrono::milliseconds patience{60'000};  ///< for the other to come, or to be there
  std::chrono::milliseconds silence{10'000};   ///< who says nothing for so long is gone …
  std::chrono::milliseconds strange_silence{
      3'000};  ///< … and who came to an invitation, but has not said anything yet
  std::chrono::milliseconds beat{1'000};  ///< between signs of life
  std::size_t most_line = 64 * 1024;      ///< bytes of a line, with its end
  std::size_t most_waiting = 4096;        ///< lines that nobody has polled: until then no more are read
};

class PeerLink {
 public:
  /// Listens on a local address; one may join. Whose first line is no JSON object is no player: it listens on. Port 0: a
  /// free one. kUnavailable where that cannot be listened on.
  static Expected<std::unique_ptr<PeerLink>> invite(const std::string& address, std::uint16_t port,
                                                    PeerSettings settings = {});
  /// Connects, again and again until the patience is over.
  static std::unique_ptr<PeerLink> join(std::string host, std::uint16_t port, PeerSettings settings = {});
  /// Sends what is left for a second at most.
  ~PeerLink();
  PeerLink(const PeerLink&) = delete;
  PeerLink& operator=(const PeerLink&) = delete;

  void send(std::string line);  ///< without its end
  /// What has come since the last call, and at most so many lines of it.
  std::vector<std::string> poll(std::size_t most = std::numeric_limits<std::size_t>::max());
  /// Why nothing will come any more, when everything has been polled that came before; for people.
  std::optional<std::string> ended() const;
  std::uint16_t port() const;  ///< invite(): where it listens

 private:
  struct State;
  explicit PeerLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fracture::game
