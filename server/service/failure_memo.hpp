// Requests whose answers did not prove themselves: asked again, they get the same error without the work.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "common/base/error.hpp"

namespace fracture {

/// The latest of them, in memory alone: a tier below would outlive the fault. Thread-safe.
class FailureMemo {
 public:
  /// Counts it, and forgets the oldest when there are too many.
  void add(const std::string& key, const Error& error) {
    const std::lock_guard lock(mutex_);
    ++count_;
    if (!errors_.emplace(key, error).second) return;
    order_.push_back(key);
    if (order_.size() <= kMost) return;
    errors_.erase(order_.front());
    order_.pop_front();
  }
  std::optional<Error> find(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = errors_.find(key);
    return at == errors_.end() ? std::nullopt : std::optional(at->second);
  }
  /// How many were ever added.
  std::uint64_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }

  static constexpr std::size_t kMost = 256;

 private:
  mutable std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::unordered_map<std::string, Error> errors_;  // only looked up
  std::deque<std::string> order_;                  // oldest first
};

}  // namespace fracture
