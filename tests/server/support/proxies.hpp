// HAProxy and nginx in front of a server, as children of the test on loopback ports, with all their files in
// a temporary folder. Each logs one line `request <figure> <status>` for each request that it saw; the figure
// is negative or missing if the request was not sent on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/support/child_process.hpp"

namespace fracture::test {

class Proxy {
 public:
  enum class Kind { kHaproxy, kNginx };

  static const char* name(Kind kind) { return kind == Kind::kHaproxy ? "haproxy" : "nginx"; }
  static bool installed(Kind kind) { return find_program(name(kind)).has_value(); }

  struct Server {
    std::uint16_t port;
    std::uint16_t admin_port =
        0;  ///< HAProxy asks its /readyz whether the server gets requests; 0: it always does
  };

  Proxy(Kind kind, std::uint16_t server_port) : Proxy(kind, std::vector<Server>{{server_port}}) {}
  /// Returns once the proxy listens.
  Proxy(Kind kind, const std::vector<Server>& servers);

  struct Counts {
    int seen = 0, sent_on = 0;
  };
  Counts counts() const;
  std::string log() const { return read_file(log_); }
  bool alive() { return process_->alive(); }

 private:
  TemporaryFolder folder_;
  std::string log_;
  std::unique_ptr<ChildProcess> process_;

 public:
  const std::uint16_t port;
};

}  // namespace fracture::test
