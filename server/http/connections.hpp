// Who is connected: counts for the limits, and a handle on every session for the drain.
#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace fracture::http {

/// What the drain does to a session, from any thread.
class Drainable {
 public:
  virtual ~Drainable() = default;
  virtual void close_when_idle() = 0;
  virtual void cancel_job() = 0;
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
