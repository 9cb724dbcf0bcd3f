// A server for bakes that can misbehave.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "tests/server/support/relay.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::bake {

/// The real server, and a relay in front of it. All requests pass through the relay, each on its own
/// connection.
struct Farm {
  using Rude = std::function<std::optional<test::FakeReply>(const test::FakeRequest&)>;

  explicit Farm(const test::TestServerOptions& options = {}) : server(options) {}

  test::FakeReply answer(const test::FakeRequest& request) {
    {
      const std::lock_guard lock(mutex);
      if (rude)
        if (std::optional<test::FakeReply> reply = rude(request)) return std::move(*reply);
    }
    return test::pass_on(request, server.port());
  }
  /// Number of requests that begin with `beginning`.
  int count(const std::string& beginning) const {
    int n = 0;
    for (const test::FakeRequest& request : relay.requests()) n += request.head.starts_with(beginning);
    return n;
  }

  test::TestServer server;
  std::mutex mutex;
  Rude rude;  ///< guarded by the mutex
  test::FakeServer relay{[this](const test::FakeRequest& request) { return answer(request); }};
};

}  // namespace fracture::bake
