// Single flight: if several callers want the same value at the same time, one computes it and all get it. The computation
// belongs to the flight and not to the first caller, so it is stopped only after the last waiter has left. Nobody blocks,
// because a waiter is a callback.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/base/error.hpp"

namespace fracture {

struct Nothing {};

/// Thread-safe. Callbacks run without the lock, on the thread that lands the flight. `Common` is data that all waiters of a
/// flight share; it must be thread-safe itself.
template <class Value, class Common = Nothing>
class SingleFlight {
 public:
  using Outcome = Expected<Value>;
  enum class Role {
    kLeader,  ///< the flight began with this waiter, so its caller must compute the value and land the flight
    kFollower,  ///< joined later
  };
  using Waiter = std::function<void(const Outcome&, Role)>;

  class Flight {
   public:
    Common common;
    const std::string& key() const { return key_; }
    /// Requested when the last waiter has left.
    std::stop_token stop() const { return stop_.get_token(); }

   private:
    friend SingleFlight;
    explicit Flight(std::string key) : key_(std::move(key)) {}
    const std::string key_;
    std::stop_source stop_;
    std::map<std::uint64_t, Waiter> waiters_;  // in the order in which they joined
    std::uint64_t next_ = 0;
    bool over_ = false;
  };

  struct Seat {
    std::shared_ptr<Flight> flight;
    std::uint64_t number = 0;
    Role role = Role::kFollower;
  };

  /// Takes a seat in this key's flight. Starts a new flight if there is none.
  Seat join(const std::string& key, Waiter waiter) {
    const std::lock_guard lock(mutex_);
    const auto at = flights_.find(key);
    Seat seat;
    if (at == flights_.end()) {
      seat.flight = std::shared_ptr<Flight>(new Flight(key));
      seat.role = Role::kLeader;
    } else {
      seat.flight = at->second;
    }
    seat.number = seat.flight->next_++;
    seat.flight->waiters_.emplace(seat.number, std::move(waiter));
    // Last, because a flight without a leader would never land.
    if (at == flights_.end()) flights_.emplace(key, seat.flight);
    return seat;
  }

  /// Gives up the seat, so that its waiter will not be called. Returns false if it is too late: the waiter was called, or is
  /// being called. If the last waiter leaves, the computation is stopped, and the next join() starts a new flight.
  bool leave(const Seat& seat) {
    Waiter dropped;  // destroyed without the lock; the stop callbacks also run without it
    std::shared_ptr<Flight> abandoned;
    {
      const std::lock_guard lock(mutex_);
      Flight& flight = *seat.flight;
      const auto at = flight.waiters_.find(seat.number);
      if (flight.over_ || at == flight.waiters_.end()) return false;
      dropped = std::move(at->second);
      flight.waiters_.erase(at);
      if (flight.waiters_.empty()) {
        flight.over_ = true;
        flights_.erase(flight.key_);
        abandoned = seat.flight;
      }
    }
    if (abandoned) abandoned->stop_.request_stop();
    return true;
  }

  /// Passes the outcome to all remaining waiters. Does nothing if all have left. After all have been called, rethrows the
  /// first exception that one of them threw.
  void land(const std::shared_ptr<Flight>& flight, const Outcome& outcome) {
    std::map<std::uint64_t, Waiter> waiters;
    {
      const std::lock_guard lock(mutex_);
      if (flight->over_) return;
      flight->over_ = true;
      flights_.erase(flight->key_);
      waiters.swap(flight->waiters_);
    }
    std::exception_ptr first;
    for (const auto& [number, waiter] : waiters) try {
        waiter(outcome, number == 0 ? Role::kLeader : Role::kFollower);
      } catch (...) {
        if (!first) first = std::current_exception();
      }
    if (first) std::rethrow_exception(first);
  }

  /// Returns this key's flight; null if there is none.
  std::shared_ptr<Flight> find(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = flights_.find(key);
    return at == flights_.end() ? nullptr : at->second;
  }

  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return flights_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<Flight>> flights_;
};

}  // namespace fracture
