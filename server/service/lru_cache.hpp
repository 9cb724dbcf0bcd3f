// A cache of shared immutable values with a budget in bytes. The least recently used entries leave first; who
// still holds a value keeps it alive, the cache merely forgets it.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

namespace fracture {

/// Invariants: bytes() is the sum of the sizes of the entries and at most the budget; every entry stands in
/// the list and in the index. Thread-safe.
template <class Value>
class LruCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  explicit LruCache(std::size_t budget) : budget_(budget) {}

  /// Null when absent.
  Pointer find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    if (at == index_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, at->second);
    return at->second->value;
  }

  /// False, and nothing changes, when the value alone is over the budget. An entry of the same key is
  /// replaced.
  bool insert(const std::string& key, Pointer value, std::size_t size) {
    if (size > budget_) return false;
    const std::lock_guard lock(mutex_);
    if (const auto at = index_.find(key); at != index_.end()) remove(at->second);
    while (bytes_ + size > budget_) remove(std::prev(entries_.end()));
    entries_.push_front({key, std::move(value), size});
    index_.emplace(key, entries_.begin());
    bytes_ += size;
    return true;
  }

  std::size_t bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return entries_.size();
  }

 private:
  struct Entry {
    std::string key;
    Pointer value;
    std::size_t size;
  };
  using Iterator = typename std::list<Entry>::iterator;

  void remove(Iterator at) {
    bytes_ -= at->size;
    index_.erase(at->key);
    entries_.erase(at);
  }

  const std::size_t budget_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;  // most recently used first
  std::unordered_map<std::string, Iterator> index_;
  std::size_t bytes_ = 0;
};

}  // namespace fracture
