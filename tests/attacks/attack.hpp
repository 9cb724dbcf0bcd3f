// A fresh server under attack: what it has resident is watched, and neighbours, who mean no harm, ask all the
// while. Every attack is one row of a table that is printed at the end.
//
// FRACTURE_TEST_SERVER=PROGRAM runs the attacks against another build, one without the limit concerned, say.
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

/// One line of the table; `before`: what the attack did to servers without the limit.
void report(const std::string& attack, const std::string& measured, const std::string& before);

/// Neighbours have been served when they have had so many answers.
inline constexpr int kServed = 12;

/// Who breaks something in a game (a stored mesh, put again where it is forgotten, as the interface says),
/// and who asks for /version and /livez. One connection at a time each, from 127.0.0.1. 503 with Retry-After
/// is a refusal, which a server in little memory may give; everything else but 200 is a failure.
class Neighbours {
 public:
  explicit Neighbours(const ServeProcess& server);
  ~Neighbours();
  void stop();
  std::string first_failure() const;
  /// The processor seconds of the server between a question and its answer, the worst: how long somebody
  /// waits for others, whatever else the machine does.
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
  /// `settings` beside --memory 768MiB, two import workers and a realtime deadline that no busy machine
  /// reaches.
  explicit Siege(std::vector<std::string> settings = {});

  /// Each of so many attackers, with addresses of their own (127.0.1.x), calls once(from, n) `least` times,
  /// and goes on until the neighbours have been served; then all are gone. once: the status of the answer.
  /// Being cut off (an exception) counts as 0.
  void attack(int attackers, int least, const std::function<int(const std::string& from, int n)>& once);
  /// What the attackers were answered, such as "400: 12, 503: 3".
  std::string answers() const;

  enum class Refusals { kAllowed, kNone };
  /// Fails the test unless memory stayed within what the server may have, the neighbours were served without
  /// a failure and the server ends as it should. Reports the row.
  void judge(const std::string& attack, const std::string& before, Refusals refusals = Refusals::kAllowed,
             const std::string& more = "");

  ServeProcess server;
  const std::uint64_t memory;  ///< bytes that it may have resident
  std::map<int, int> statuses;

 private:
  ResidentPeak peak_;

 public:
  std::unique_ptr<Neighbours> neighbours;
};

}  // namespace fracture::test
