#include "server/cache/resolver.hpp"

#include <netdb.h>

#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace fracture {

namespace {

/// Returns the addresses in the order in which they should be tried. On failure, returns none and sets `error`.
std::vector<NetworkAddress> look_up(const std::string& host, const std::string& port, int flags, int& error) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  error = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  std::vector<NetworkAddress> addresses;
  for (const addrinfo* at = error == 0 ? found : nullptr; at != nullptr; at = at->ai_next) {
    NetworkAddress address;
    address.size = at->ai_addrlen;
    std::memcpy(&address.storage, at->ai_addr, at->ai_addrlen);
    addresses.push_back(address);
  }
  if (found != nullptr) ::freeaddrinfo(found);
  return addresses;
}

}  // namespace

struct Resolver::State {
  std::string host, port;
  std::mutex mutex;
  Known known;
  bool asking = false, numeric = false;
  std::chrono::steady_clock::time_point answered{};
};

Resolver::Resolver(std::string host, std::string port) : state_(std::make_shared<State>()) {
  state_->host = std::move(host);
  state_->port = std::move(port);
  int error = 0;
  state_->known.addresses =
      look_up(state_->host, state_->port, AI_NUMERICHOST | AI_NUMERICSERV, error);  // sends no query
  state_->numeric = state_->known.asked = error == 0;
  if (state_->numeric) return;
  state_->asking = true;
  ask(state_);
}

Resolver::Known Resolver::known() {
  const std::lock_guard lock(state_->mutex);
  if (!state_->numeric && !state_->asking && std::chrono::steady_clock::now() - state_->answered >= kFresh) {
    state_->asking = true;
    ask(state_);
  }
  return state_->known;
}

/// Starts a look-up on a detached thread, because it cannot be stopped. The thread holds only the state.
void Resolver::ask(const std::shared_ptr<State>& state) {
  try {
    std::thread([state] {
      int error = 0;
      std::vector<NetworkAddress> addresses = look_up(state->host, state->port, 0, error);
      const std::lock_guard lock(state->mutex);
      // If a name server fails for a while, the known addresses are kept.
      if (!addresses.empty() || error == EAI_NONAME) state->known.addresses = std::move(addresses);
      state->known.asked = true;
      state->answered = std::chrono::steady_clock::now();
      state->asking = false;
    }).detach();
  } catch (const std::system_error&) {  // no thread is available: the next call tries again
    state->asking = false;
  }
}

}  // namespace fracture
