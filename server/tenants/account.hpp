// What one name has used and may still use, while the server runs. Outlives a reload of the token file: who
// is over its share is not forgiven by one.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "server/tenants/rate.hpp"
#include "server/tenants/tenant.hpp"

namespace fracture::tenants {

/// Thread-safe.
class Account : public std::enable_shared_from_this<Account> {
 public:
  using Clock = Bucket::Clock;

  /// `isolated`: sees only what it made or uploaded itself.
  Account(Tenant tenant, bool isolated);
  /// What the file says now.
  void configure(Tenant tenant, bool isolated);

  const std::string& name() const { return name_; }
  Scopes scopes() const;
  Shares shares() const;
  /// Whose the things are that it makes: its name, or nothing in particular where all names share.
  std::string owner() const;
  /// May it see what belongs to `owner`?
  bool sees(const std::string& owner) const;

  /// Counts a request. kOverShare over the share.
  std::optional<Error> request(Clock::time_point now = Clock::now());
  /// RateLimit and RateLimit-Policy (draft-ietf-httpapi-ratelimit-headers), for an answer to it: what is left
  /// of the shares that have a limit.
  std::vector<std::pair<std::string, std::string>> rate_fields(Clock::time_point now = Clock::now());

  /// A computation of this name, queued or running, from its construction to its destruction.
  class Seat {
   public:
    Seat() = default;
    explicit Seat(std::shared_ptr<Account> account) : account_(std::move(account)) {}
    Seat(Seat&&) noexcept = default;
    Seat& operator=(Seat&& other) noexcept {
      std::swap(account_, other.account_);
      return *this;
    }
    ~Seat() {
      if (account_) --account_->computations_;
    }
    explicit operator bool() const { return account_ != nullptr; }

   private:
    std::shared_ptr<Account> account_;
  };
  /// kOverShare over the share.
  Expected<Seat> begin_computation(Clock::time_point now = Clock::now());
  /// It has used more processor time than it may by now: what it asked for stands still.
  bool is_over_processor_rate(Clock::time_point now = Clock::now());
  /// Processor seconds that were spent for this name, all threads together.
  void charge(double processor_seconds, Clock::time_point now = Clock::now());
  void count_answer(std::uint64_t bytes_in, std::uint64_t bytes_out);

  struct Figures {
    std::uint64_t requests = 0, over_share = 0, bytes_in = 0, bytes_out = 0, computations = 0;
    double processor_seconds = 0;
  };
  Figures figures() const;

 private:
  Error over(std::string what, std::chrono::duration<double> wait);
  void advance(Clock::time_point now);

  const std::string name_;
  mutable std::mutex mutex_;
  Scopes scopes_;
  Shares shares_;
  bool isolated_;
  Bucket requests_, processor_;
  Figures figures_;
  std::atomic<std::uint64_t> computations_{0};
};

}  // namespace fracture::tenants
