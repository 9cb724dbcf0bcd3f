// Resolves a host name without ever waiting. getaddrinfo() has no deadline, so a name server that does not answer would
// block a computing thread for half a minute.
#pragma once

#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace fracture {

struct NetworkAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// Thread-safe.
class Resolver {
 public:
  /// How long an answer is used. After that, the name is resolved again, so that a service that moved is found.
  static constexpr std::chrono::seconds kFresh{30};

  /// Starts resolving at once, on a separate thread. A numeric address is known at once.
  Resolver(std::string host, std::string port);

  struct Known {
    std::vector<NetworkAddress> addresses;
    bool asked = false;  ///< a look-up has ended; if `addresses` is empty, there are none
  };
  /// Returns what is known now. Starts another look-up in the background if this is old.
  Known known();

 private:
  struct State;
  static void ask(const std::shared_ptr<State>& state);
  const std::shared_ptr<State> state_;  ///< shared with a thread that may outlive this object
};

}  // namespace fracture
