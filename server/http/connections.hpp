// Who is connected: counts for the limits, and a handle on every session for the drain.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace fracture::http {

/// What the drain and a full listener do to a session, from any thread.
class Drainable {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~Drainable() = default;
  virtual void close_when_idle() = 0;
  virtual void cancel_job() = 0;
  /// Other tokens are in force: it may have to stop what it delivers.
  virtual void tokens_changed() = 0;
  /// Closes, unless it computes an answer by now.
  virtual void give_way() = 0;

  /// Since when it has only waited for its client: for a request, for the rest of a header, for its taking an answer,
  /// for the end of the connection. Nothing while it computes one.
  std::optional<Clock::time_point> waiting_since() const {
    const Clock::rep since = waiting_since_;
    return since == 0 ? std::nullopt : std::optional(Clock::time_point(Clock::duration(since)));
  }

 protected:
  void set_waiting(bool waiting) { waiting_since_ = waiting ? Clock::now().time_since_epoch().count() : 0; }

 private:
  std::atomic<Clock::rep> waiting_since_{Clock::now().time_since_epoch().count()};
};

/// Thread-safe. A session is registered from its accept to its destruction.
class Connections {
 public:
  enum class Verdict { kWelcome, kTooManyOfAddress, kFull };

  Connections(std::size_t max, std::size_t max_per_address) : max_(max), max_per_address_(max_per_address) {}

  enum class PerAddress { kLimited, kUnlimited };
  Verdict add(const std::string& address, PerAddress limit = PerAddress::kLimited) {
    const std::lock_guard lock(mutex_);
    std::size_t& of_address = by_address_[address];
    ++of_address;
    ++count_;
    if (limit == PerAddress::kLimited && of_address > max_per_address_) return Verdict::kTooManyOfAddress;
    return count_ > max_ ? Verdict::kFull : Verdict::kWelcome;
  }
  void remove(const std::string& address) {
    const std::lock_guard lock(mutex_);
    --count_;
    if (const auto at = by_address_.find(address); --at->second == 0) by_address_.erase(at);
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }

  void enroll(const std::shared_ptr<Drainable>& session) {
    const std::lock_guard lock(mutex_);
    sessions_.insert(session);
  }
  /// Called by the session's destructor, when the weak pointer has expired but still names it.
  void forget(const std::weak_ptr<Drainable>& session) {
    const std::lock_guard lock(mutex_);
    sessions_.erase(session);
  }
  std::vector<std::shared_ptr<Drainable>> sessions() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<Drainable>> alive;
    for (const auto& session : sessions_)
      if (auto pointer = session.lock()) alive.push_back(std::move(pointer));
    return alive;
  }

  /// The one that has waited longest gives its place to a new one. False when all are being answered.
  bool close_longest_waiting() const {
    std::shared_ptr<Drainable> longest;
    std::optional<Drainable::Clock::time_point> earliest;
    for (const auto& session : sessions()) {
      const auto since = session->waiting_since();
      if (!since || (earliest && *earliest <= *since)) continue;
      earliest = since;
      longest = session;
    }
    if (longest) longest->give_way();
    return longest != nullptr;
  }

  std::atomic<bool> stopping{false};  ///< the drain has begun: no connection is kept after its answer
  std::atomic<std::size_t> in_progress{
      0};  ///< sessions between the first byte of a request and the last of its answer

 private:
  const std::size_t max_, max_per_address_;
  mutable std::mutex mutex_;
  std::size_t count_ = 0;
  std::map<std::string, std::size_t> by_address_;
  std::set<std::weak_ptr<Drainable>, std::owner_less<std::weak_ptr<Drainable>>> sessions_;
};

}  // namespace fracture::http
