// Malformed and ambiguous requests. Each is complete from its author's view. The bytes after such a request
// must never be taken for another request. The requests marked `valid` are a control: they show that the
// corpus can tell the difference. The corpus is used against the server alone and with proxies in front.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fracture::test {

struct HostileRequest {
  std::string name;
  std::string bytes;
  int status;          ///< of the server's answer without a proxy in front
  bool valid = false;  ///< well-formed: the next request on the connection is answered, too
};

std::vector<HostileRequest> hostile_corpus();

/// Status lines in the bytes that a connection received.
std::size_t count_answers(const std::string& received);

/// Sent after each request of the corpus. Its answer contains "smuggled", so a smuggled request is noticed.
inline const std::string kSmuggled =
    "GET /version HTTP/1.1\r\nHost: a\r\nX-Request-Id: smuggled\r\nConnection: close\r\n\r\n";

}  // namespace fracture::test
