// Compresses answers, each once for all requests that want it at that time.
//
// Each request waits for its own turn. The first whose turn comes compresses the answer for all, and the others then leave the
// queue. So no request waits for the turn of another client, whose places may be taken, or who may be over its processor rate.
//
// If a request's turn comes while another one compresses, it lets its turn pass and waits. But the other compression may
// stand still for as long as its client's other work takes. So it is waited for only as long as a compression should take.
// After that, the next client compresses the answer, too. Each client may do so once, so that many requests of one client
// hold up the others no longer than one. A request also does not wait for less urgent compressions.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/dispatcher.hpp"
#include "server/service/single_flight.hpp"

namespace fracture::http {

/// Thread-safe. Must outlive all requests that wait.
class Compressions {
 public:
  using Made = std::shared_ptr<const FractureResult>;
  struct Wanted {
    std::string key{};  ///< identifies the compressed answer
    ExpectedWork work{};
    Terms terms{};                        ///< of the request: its client, class, deadline and stop token
    std::chrono::milliseconds longest{};  ///< time of one attempt, with its wait in the queue
    std::function<Made(const Execution&)> make{};  ///< may be called by several threads
    /// Called once, from any thread: with the compressed answer, or with the reason why this request does not get it.
    std::function<void(const Expected<Made>&)> reply{};
  };

  explicit Compressions(Dispatcher& dispatcher) : dispatcher_(dispatcher) {}
  /// Replies later, or before it returns. If it throws, it does not reply.
  void obtain(Wanted wanted);

  /// A request waits for the compression of another client at least this long.
  static constexpr std::chrono::milliseconds kLeastPatience{10};

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiter;
  struct Attempt {
    std::string client;
    Priority priority;
    bool operator==(const Attempt&) const = default;
  };
  /// The attempts to compress one answer. All requests that wait for it share them.
  struct Attempts {
    std::mutex mutex;  // guards all but `done`
    std::vector<Attempt> running;
    std::vector<std::string> begun;             ///< clients that have begun an attempt
    std::vector<std::weak_ptr<Waiter>> passed;  ///< let their turn pass; empty if nothing runs
    Clock::time_point latest{};                 ///< when an attempt began that others wait for
    bool is_expected = false;                   ///< a task with the expected seconds was queued
    bool over = false;                          ///< one of them succeeded
    std::stop_source done;                      ///< ends the attempts that still run
  };
  using Flights = SingleFlight<Made, Attempts>;

  /// Queues a request for its turn.
  void queue(const std::shared_ptr<Waiter>& waiter, bool is_computed);
  /// Queues a request that let its turn pass. If that fails, the request gets the reason.
  void queue_again(const std::weak_ptr<Waiter>& weak);
  /// Returns whether the request lets its turn pass. It is queued again if the others fail or take too long.
  bool passes(const std::shared_ptr<Waiter>& waiter);
  void look_later(const std::shared_ptr<Waiter>& waiter, Clock::time_point when);
  /// Queues a request again if it has waited for long enough.
  void look_again(const std::shared_ptr<Waiter>& waiter);
  /// The request's turn has come.
  void compress(const std::shared_ptr<Waiter>& waiter, const Execution& execution);
  static Expected<Made> attempt(const Waiter& waiter, const Execution& execution);
  void ended(const std::shared_ptr<Waiter>& waiter, const Attempt& mine, const Expected<Made>& made);
  // These require the lock.
  static bool has_begun(const Attempts& attempts, const Waiter& waiter);
  static bool is_in_time(const Attempts& attempts, const Waiter& waiter);
  static bool may_begin(const Attempts& attempts, const Waiter& waiter);
  bool passes(Attempts& attempts, const std::shared_ptr<Waiter>& waiter);

  Dispatcher& dispatcher_;
  Flights flights_;
};

}  // namespace fracture::http
