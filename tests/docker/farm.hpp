// Runs docker/compose.yaml with plain processes on the loopback: three servers, a Redis, and HAProxy with the
// repository's own configuration. In that configuration only addresses, timeouts and the number of
// connections are replaced. Each answer names the server that gave it. Every wait has a limit.
#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/server/support/child_process.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_program.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

inline constexpr int kServers = 3;

/// Returns ports of 127.0.0.1 below those that the kernel gives to connections. So no process takes a port
/// while its server is down.
inline std::uint16_t lasting_port() {
  static unsigned next = static_cast<unsigned>(::getpid()) * 16;
  int first_given = 32'768;
  std::ifstream("/proc/sys/net/ipv4/ip_local_port_range") >> first_given;
  constexpr int kFirst = 10'240;
  for (int tries = 0; tries < 1000; ++tries) {
    const int port =
        kFirst + static_cast<int>(next++ % static_cast<unsigned>(std::max(first_given - kFirst, 1000)));
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const bool free = ::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
    ::close(fd);
    if (free) return static_cast<std::uint16_t>(port);
  }
  throw std::runtime_error("no free port");
}

/// Returns the exit code (1000 + the signal) of a process that should end by itself. Throws if it does not.
inline int exit_code(ChildProcess& process, const std::string& name) {
  require_eventually(kPatience, "the end of " + name, [&] { return !process.alive(); });
  return process.wait();
}

/// Replaces each of `count` occurrences. Throws if there are more or fewer, since the configuration has
/// changed then.
inline void replace(std::string& text, const std::string& from, const std::string& to, int count = 1) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
    --count;
  }
  if (count != 0)
    throw std::runtime_error("haproxy.cfg: '" + from + "' stands there more or less often than was thought");
}

class Redis {
 public:
  Redis() { start(); }
  void start() {
    process_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{*find_program("redis-server"), "--port", std::to_string(port), "--bind",
                                 "127.0.0.1", "--save", "", "--appendonly", "no", "--dir", folder_.path},
        folder_ / "output");
    require_eventually(kPatience, "an answer of redis-server", [&] {
      if (!process_->alive()) throw std::runtime_error("redis-server: " + read_file(folder_ / "output"));
      return entries().has_value();
    });
  }
  void kill() { process_.reset(); }
  /// The number of keys it holds. Returns nothing if it does not answer.
  std::optional<int> entries() const {
    try {
      RawClient client(port);
      client.send("DBSIZE\r\n");
      client.half_close();
      const std::string reply = client.receive_all();
      if (reply.empty() || reply[0] != ':') return std::nullopt;
      return std::atoi(reply.c_str() + 1);
    } catch (const std::runtime_error&) {
      return std::nullopt;
    }
  }
  const std::uint16_t port = lasting_port();

 private:
  TemporaryFolder folder_;
  std::unique_ptr<ChildProcess> process_;
};

class Farm {
 public:
  static std::string missing() {
    for (const char* program : {"haproxy", "redis-server"})
      if (!find_program(program)) return std::string(program) + " is not installed";
    return "";
  }

  explicit Farm(std::string drain_delay) : drain_delay_(std::move(drain_delay)) {
    for (int i = 0; i < kServers; ++i) start(i);
    std::string text = read_file(FRACTURE_HAPROXY_CFG);
    replace(text, "bind :8080\n", "bind 127.0.0.1:" + std::to_string(port) + "\n");
    replace(text, "bind :8404\n", "bind 127.0.0.1:" + std::to_string(statistics_port_) + "\n");
    for (int i = 0; i < kServers; ++i) {
      const std::string name = "fracture" + std::to_string(i + 1) + ":8080";
      const std::string address = "127.0.0.1:" + std::to_string(ports_[i].port);
      replace(text, name + " track", address + " track");
      replace(text, name + "\n", address + " port " + std::to_string(ports_[i].admin) + "\n");
    }
    // HAProxy drops lines of its log if they are not read fast enough. Its answers always arrive.
    replace(text, "    default_backend any\n",
            "    default_backend any\n    http-response set-header " + std::string(kAnsweredBy) + " %s\n");
    // Each connection takes two descriptors, and a user may have no more than 1024.
    replace(text, "    maxconn 4000\n", "    maxconn 200\n");
    without_timeouts(text);
    haproxy_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{*find_program("haproxy"), "-db", "-f", folder_.write("haproxy.cfg", text)},
        folder_ / "haproxy.log");
    for (int i = 0; i < kServers; ++i) wait_until(i, "UP");
  }

  /// Returns when the server is ready. HAProxy may not have noticed that yet.
  void start(int i) {
    servers_[i] = std::make_unique<ChildProcess>(
        std::vector<std::string>{server_program(), "serve", "--port", std::to_string(ports_[i].port),
                                 "--admin-port", std::to_string(ports_[i].admin), "--threads", "1",
                                 "--import-workers", "1", "--redis",
                                 "127.0.0.1:" + std::to_string(redis.port), "--drain-delay", drain_delay_,
                                 "--max-connections-per-address", "1024"},
        folder_ / ("fracture" + std::to_string(i + 1) + ".log"));
    protect_the_machine_from(servers_[i]->pid());
    require_eventually(kPatience, "a ready fracture" + std::to_string(i + 1), [&] {
      check_alive(i);
      try {
        return ask(ports_[i].admin, "GET", "/readyz").status == 200;
      } catch (const std::runtime_error&) {
        return false;
      }
    });
  }
  ChildProcess& server(int i) { return *servers_[i]; }
  void kill(int i) { servers_[i].reset(); }

  /// Waits until HAProxy reports this status ("UP", "DOWN") of a server. Throws if it does not, or if a
  /// server that should be up ended instead.
  void wait_until(int i, const std::string& status) const {
    require_eventually(kPatience, "HAProxy to say that fracture" + std::to_string(i + 1) + " is " + status,
                       [&] {
                         if (!haproxy_->alive()) throw std::runtime_error("haproxy: " + log());
                         if (status == "UP") check_alive(i);
                         return statistic(i, kStatusColumn) == status;
                       });
  }
  /// The number of servers to which HAProxy has sent a request about a mesh since it was started.
  int used_servers() const {
    int used = 0;
    for (int i = 0; i < kServers; ++i)
      if (std::atoll(statistic(i, kRequestsColumn).c_str()) > 0) ++used;
    return used;
  }
  /// The sum of a figure over the servers that run.
  double sum(const std::string& family, const std::string& label = "") const {
    double total = 0;
    for (int i = 0; i < kServers; ++i)
      if (servers_[i])
        total += parse_exposition(ask(ports_[i].admin, "GET", "/metrics").body).sum(family, label);
    return total;
  }
  /// Asks for each path, one after the other, and returns the server that answered it. Throws if none did.
  std::vector<std::string> servers_of(const std::vector<std::string>& paths) const {
    std::vector<std::string> servers;
    for (const std::string& path : paths) {
      const Reply reply = ask(port, "HEAD", path);
      servers.push_back(reply.header(kAnsweredBy));
      if (servers.back().empty())
        throw std::runtime_error("HAProxy itself answered HEAD " + path + " with " +
                                 std::to_string(reply.status));
    }
    return servers;
  }
  std::string log() const { return read_file(folder_ / "haproxy.log"); }

  Redis redis;
  const std::uint16_t port = lasting_port();

 private:
  struct Ports {
    std::uint16_t port = lasting_port(), admin = lasting_port();
  };

  void check_alive(int i) const {
    if (!servers_[i]->alive())
      throw std::runtime_error("the server ended: " +
                               read_file(folder_ / ("fracture" + std::to_string(i + 1) + ".log")));
  }
  /// Sets every line "timeout …" to an hour, so that a busy machine is not mistaken for a failure. A killed
  /// server is still noticed: it refuses connections.
  static void without_timeouts(std::string& text) {
    int found = 0;
    for (std::size_t at = 0; (at = text.find("\n    timeout ", at)) != std::string::npos; ++found) {
      const std::size_t end = text.find('\n', at + 1), value = text.rfind(' ', end);
      text.replace(value + 1, end - value - 1, "1h");
      ++at;
    }
    if (found < 6) throw std::runtime_error("haproxy.cfg: where are the timeouts?");
  }
  /// A field of HAProxy's statistics about a server. It is empty while HAProxy does not answer.
  std::string statistic(int i, int column) const {
    try {
      RawClient client(statistics_port_);
      client.send("GET /;csv HTTP/1.0\r\n\r\n");  // HTTP/1.0 has no chunks
      std::istringstream lines(client.receive_all());
      const std::string name = "of_a_mesh,fracture" + std::to_string(i + 1) + ",";
      for (std::string line; std::getline(lines, line);) {
        if (line.rfind(name, 0) != 0) continue;
        std::istringstream fields(line);
        std::string field;
        for (int c = 0; c <= column; ++c) std::getline(fields, field, ',');
        return field;
      }
    } catch (const std::runtime_error&) {
    }
    return "";
  }

  /// Columns of the statistics, by the numbers in section 9.1 of HAProxy's management guide: stot and status.
  static constexpr int kRequestsColumn = 7, kStatusColumn = 17;
  /// Name, in lower case, of the header that the test's configuration adds to every answer of a server.
  static constexpr const char* kAnsweredBy = "x-answered-by";

  const std::string drain_delay_;
  const std::uint16_t statistics_port_ = lasting_port();
  std::array<Ports, kServers> ports_;
  TemporaryFolder folder_;
  std::array<std::unique_ptr<ChildProcess>, kServers> servers_;
  std::unique_ptr<ChildProcess> haproxy_;
};

}  // namespace fracture::test
