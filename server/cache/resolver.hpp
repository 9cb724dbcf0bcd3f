// A host name's addresses without ever waiting for them: getaddrinfo() has no deadline, and a name server
// that does not answer would hold a computing thread for half a minute.
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
  /// How long an answer is good for: a service that moved is found again after it.
  static constexpr std::chrono::seconds kFresh{30};

  /// Begins to resolve at once, on a thread of its own; what is numeric is known at once.
  Resolver(std::string host, std::string port);

  struct Known {
    std::vector<NetworkAddress> addresses;
    bool asked = false;  ///< an answer has come; without addresses: there are none
  };
  /// What is known now; asks again behind the caller's back when that is old.
  Known known();

 private:
  struct State;
  static void ask(const std::shared_ptr<State>& state);
  const std::shared_ptr<State> state_;  ///< shared with a thread that may outlive this
};

}  // namespace fracture
