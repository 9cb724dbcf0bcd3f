// Malformed and ambiguous requests, each complete as far as its author would say. What follows one of them on
// the connection must never be taken for a request of its own, unless it is `valid`: a control that shows
// that the corpus can tell the difference. Used against the server alone and with proxies in front.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fracture::test {

struct HostileRequest {
  std::string name;
  std::string bytes;
  int status;          ///< of the server's answer when nothing stands in front of it
  bool valid = false;  ///< well-formed: the next request on the connection is answered, too
};

std::vector<HostileRequest> hostile_corpus();

/// Status lines in what a connection received.
std::size_t count_answers(const std::string& received);

/// A request that says so when it is answered: sent after each of the corpus.
inline const std::string kSmuggled =
    "GET /version HTTP/1.1\r\nHost: a\r\nX-Request-Id: smuggled\r\nConnection: close\r\n\r\n";

}  // namespace fracture::test
