// Code for tests of the protocol client: a server that answers as a test wants, and patience.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "client/protocol/client.hpp"
#include "tests/client/fake_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::protocol {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;

inline const std::string kFragments = "glTF: pretended fragments";
// printf 'glTF: pretended fragments' | openssl dgst -sha256 -binary | base64
inline const std::string kDigest = "Repr-Digest: sha-256=:G85sfc2HGlq0xr5AGgYU4JG0eDOCIaTZo6vESsOur54=:\r\n";

inline FakeReply fragments(const std::string& more = "") {
  return FakeReply::answer(200, kFragments, kDigest + more);
}
inline FakeReply problem(int status, const std::string& slug, const std::string& headers = "") {
  return FakeReply::answer(status, R"({"type": "/problems/)" + slug + R"(", "detail": "Because."})",
                           "Content-Type: application/problem+json\r\n" + headers);
}
inline FakeReply stored() { return FakeReply::answer(201, "{}"); }

/// Settings without a heartbeat, so that the fake server gets only the test's own requests.
inline Settings settings(std::uint16_t port) {
  Settings s;
  s.port = port;
  s.heartbeat = Milliseconds(0);
  s.first_pause = Milliseconds(1);
  s.longest_pause = Milliseconds(10);
  return s;
}

/// Waits for the next `count` answers.
inline std::vector<Answer> wait_for(Client& client, std::size_t count) {
  std::vector<Answer> all;
  test::require_eventually(test::kPatience, std::to_string(count) + " answers", [&] {
    for (Answer& answer : client.poll()) all.push_back(std::move(answer));
    return all.size() >= count;
  });
  return all;
}
inline Answer wait_for_one(Client& client) { return wait_for(client, 1).front(); }

}  // namespace fracture::protocol
