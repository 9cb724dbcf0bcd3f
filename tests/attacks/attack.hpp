// A new server under attack. Its resident memory is watched, and neighbours (clients that mean no harm) send
// requests the whole time. Every attack is a row in a table that is printed at the end.
//
// FRACTURE_TEST_SERVER=PROGRAM runs the attacks against another build, for example one without the limit in
// question.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/process_figures.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {

/// Adds a row to the table. `before` describes the effect of the attack on servers without the limit.
void report(const std::string& attack, const std::string& measured, const std::string& before);

/// An attack goes on until the neighbours have received this many further answers.
inline constexpr int kServed = 12;

/// Harmless clients: one fractures a stored mesh as a game does (it uploads the mesh again if the server has
/// forgotten it, as the interface requires), another asks for /version and /livez. Each has one connection at
/// a time, from 127.0.0.1. A 503 with Retry-After is a refusal, which a server with little memory may give;
/// every other status except 200 is a failure.
class Neighbours {
 public:
  explicit Neighbours(const ServeProcess& server);
  ~Neighbours();
  void stop();
  std::string first_failure() const;
  /// The most processor seconds that the server used between a request and its answer. This tells how long a
  /// client waits for others, whatever else the machine does.
  double worst_wait() const;

  std::atomic<int> served{0}, probes{0}, refused{0}, failed{0};

 private:
  void play(std::uint16_t port);
  void probe(std::uint16_t port, std::uint16_t admin_port);
  void time(double seconds);
  void fail(const std::string& what);

  const pid_t pid_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  double worst_ = 0;
  std::string first_failure_;
  std::vector<std::thread> threads_;
};

class Siege {
 public:
  /// `settings` are added to --memory 768MiB, two import workers and a realtime deadline that no busy machine
  /// reaches.
  explicit Siege(std::vector<std::string> settings = {});

  /// Each attacker has its own address (127.0.1.x) and calls once(from, n) at least `least` times, until the
  /// neighbours have been served. `once` returns the status of the answer. An exception means that the
  /// attacker was cut off, and counts as status 0.
  void attack(int attackers, int least, const std::function<int(const std::string& from, int n)>& once);
  /// The statuses that the attackers received, such as "400: 12, 503: 3".
  std::string answers() const;

  enum class Refusals { kAllowed, kNone };
  /// Fails the test unless memory stayed within the server's limit, the neighbours were served without a
  /// failure, and the server ends as it should. Reports the row.
  void judge(const std::string& attack, const std::string& before, Refusals refusals = Refusals::kAllowed,
             const std::string& more = "");

  ServeProcess server;
  const std::uint64_t memory;  ///< bytes that the server may have resident
  std::map<int, int> statuses;

 private:
  ResidentPeak peak_;

 public:
  std::unique_ptr<Neighbours> neighbours;
};

}  // namespace fracture::test
