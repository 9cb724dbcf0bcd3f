// Remembers requests whose answers failed their own checks. If such a request comes again, it gets the same error without
// being computed again.
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

/// Keeps the latest kMost failures, only in memory, because an entry on disk would outlive the defect. Thread-safe.
class FailureMemo {
 public:
  /// Adds and counts a failure. Forgets the oldest one if there are too many.
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
  /// Returns how many failures were added, including forgotten ones.
  std::uint64_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }

  static constexpr std::size_t kMost = 256;

 private:
  mutable std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::unordered_map<std::string, Error> errors_;  // never iterated
  std::deque<std::string> order_;                  // oldest first
};

}  // namespace fracture
