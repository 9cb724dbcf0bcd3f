// Bakers that use a server at a port of this machine, and the replies of servers that refuse.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "server/bake/remote_baker.hpp"
#include "tests/server/support/relay.hpp"

namespace fracture::bake {

inline Patience short_pauses() {
  using std::chrono::milliseconds;
  // No test waits until the patience ends, except those that set their own.
  return {milliseconds(3'600'000), milliseconds(1), milliseconds(4)};
}

/// A baker of the server at this port of the machine.
inline Expected<std::unique_ptr<Baker>> baker_at(std::uint16_t port,
                                                 const Patience& patience = short_pauses(),
                                                 const std::string& token = "") {
  protocol::ConnectionSettings settings;
  settings.port = port;
  settings.token = token;
  // The limits are long because the machine may be slow. A test that expects a failure must not rely on them.
  settings.connect_timeout = settings.answer_timeout = std::chrono::hours(1);
  return remote_baker({settings, patience}, {}, [](const std::string&) {});
}

/// A reply with a problem document.
inline test::FakeReply problem(int status, const std::string& slug, const std::string& headers = "") {
  return test::FakeReply::answer(status, R"({"type": "/problems/)" + slug + R"(", "detail": "Because."})",
                                 "Content-Type: application/problem+json\r\n" + headers);
}

}  // namespace fracture::bake
