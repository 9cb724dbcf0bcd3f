// Tracks how much one name has used and may still use while the server runs. A reload of the token file does not reset it.
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

  /// `isolated`: the name sees only what it has made or uploaded itself.
  Account(Tenant tenant, bool isolated);
  /// Applies the settings of a reloaded file.
  void configure(Tenant tenant, bool isolated);

  const std::string& name() const { return name_; }
  Scopes scopes() const;
  Shares shares() const;
  /// Returns the owner of everything that this name makes: its name, or "" if all names share everything.
  std::string owner() const;
  /// Returns whether this name may see what belongs to `owner`.
  bool sees(const std::string& owner) const;

  /// Counts a request. Returns kOverShare if the name exceeds its request rate.
  std::optional<Error> request(Clock::time_point now = Clock::now());
  /// Returns the header fields RateLimit and RateLimit-Policy (draft-ietf-httpapi-ratelimit-headers) for a response to this
  /// name. They say how much is left of its limited rates.
  std::vector<std::pair<std::string, std::string>> rate_fields(Clock::time_point now = Clock::now());

  /// Counts as one queued or running computation of this name while it lives.
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
  /// Begins a computation. Returns kOverShare if the name exceeds its processor rate or its number of computations.
  Expected<Seat> begin_computation(Clock::time_point now = Clock::now());
  /// Returns whether the name currently exceeds its processor rate. Its computations stand still in that case.
  bool is_over_processor_rate(Clock::time_point now = Clock::now());
  /// Returns how long the name's computations will stand still if nothing is charged in the meantime.
  std::chrono::duration<double> until_within_processor_rate(Clock::time_point now = Clock::now());
  /// Charges this name for processor seconds, summed over all threads.
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
