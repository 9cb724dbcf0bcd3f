// L0: a cache of shared immutable values in memory, with a budget in bytes. A single pass over many values that are requested
// only once (by a crawler, or a batch of new seeds) does not displace values that are requested often.
//
// S3-FIFO (Yang, Zhang, Qiu, Yue, Vigfusson, "FIFO queues are all you need for cache eviction", SOSP 2023):
//
//              miss          requested again               requested since
//     key ───────────> small ────────────────> main <───┐ ──────────────── (goes round once more)
//      │               10 % │ not requested      │ └────┘
//      │                    v                    v not requested
//      │                  ghost (keys only)    evicted
//      └── in ghost ────────────────────────> main
//
// We depart from the paper in two ways. The budget counts bytes instead of objects. And one further request promotes a value
// from `small` to `main`, instead of two, because a value that was requested twice is worth more than one that was not, and
// there are thousands of entries here, not millions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace fracture {

struct CacheFigures {
  std::uint64_t hits = 0, misses = 0, insertions = 0, evictions = 0;
  std::size_t bytes = 0, entries = 0;
};

/// Invariants: `bytes` is the sum of the entries' sizes and at most the budget; every entry is in exactly one queue and in the
/// index; no key is both in the index and in the ghost list. A caller that holds an evicted value keeps it alive.
/// Thread-safe.
template <class Value>
class MemoryCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  explicit MemoryCache(std::size_t budget) : budget_(budget) {}

  /// Like find(), but does not count as a request.
  Pointer peek(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    return at == index_.end() ? nullptr : at->second->value;
  }
  /// Returns the size that was given to insert(); nothing if there is no entry.
  std::optional<std::size_t> size_of(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    return at == index_.end() ? std::nullopt : std::optional(at->second->size);
  }
  /// Returns the value; null if it is not cached.
  Pointer find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    if (at == index_.end()) {
      ++figures_.misses;
      return nullptr;
    }
    ++figures_.hits;
    Entry& entry = *at->second;
    entry.uses = std::min(entry.uses + 1, kMaxUses);
    return entry.value;
  }

  /// Inserts a value, and replaces an entry with the same key. Returns false and changes nothing if the value is larger than
  /// the budget.
  bool insert(const std::string& key, Pointer value, std::size_t size) {
    if (size > budget_) return false;
    // Freed without the lock, because io threads wait for it and freeing large values takes a while
    std::vector<Pointer> dropped;
    const std::lock_guard lock(mutex_);
    if (const auto at = index_.find(key); at != index_.end()) remove(at->second, dropped);
    while (figures_.bytes + size > budget_) make_room(dropped);
    const bool again = forget_ghost(key);
    Queue& queue = again ? main_ : small_;
    queue.entries.push_front({key, std::move(value), size, 0, again});
    queue.bytes += size;
    index_.emplace(key, queue.entries.begin());
    figures_.bytes += size;
    ++figures_.insertions;
    return true;
  }

  void erase(const std::string& key) {
    std::vector<Pointer> dropped;
    const std::lock_guard lock(mutex_);
    if (const auto at = index_.find(key); at != index_.end()) remove(at->second, dropped);
  }

  CacheFigures figures() const {
    const std::lock_guard lock(mutex_);
    CacheFigures figures = figures_;
    figures.entries = index_.size();
    return figures;
  }

 private:
  static constexpr int kMaxUses = 3;
  static constexpr std::size_t kSmallShare = 10;   // `small` gets 1/10 of the budget
  static constexpr std::size_t kMinGhosts = 1024;  // 100 KB for keys of 64 digits

  struct Entry {
    std::string key;
    Pointer value;
    std::size_t size;
    int uses;
    bool in_main;
  };
  struct Queue {
    std::list<Entry> entries;  // newest first
    std::size_t bytes = 0;
  };
  using Iterator = typename std::list<Entry>::iterator;

  /// Examines the oldest entry of the queue that exceeds its share. Evicts the entry, or gives it another turn. Each turn
  /// uses up one of the entry's counted uses, so a finite number of calls frees memory.
  void make_room(std::vector<Pointer>& dropped) {
    if (main_.entries.empty() || small_.bytes > budget_ / kSmallShare) {
      const Iterator oldest = std::prev(small_.entries.end());
      if (oldest->uses > 0) {
        oldest->uses = 0;
        oldest->in_main = true;
        small_.bytes -= oldest->size;
        main_.bytes += oldest->size;
        main_.entries.splice(main_.entries.begin(), small_.entries, oldest);
      } else {
        remember_ghost(oldest->key);
        ++figures_.evictions;
        remove(oldest, dropped);
      }
    } else {
      const Iterator oldest = std::prev(main_.entries.end());
      if (oldest->uses > 0) {
        --oldest->uses;
        main_.entries.splice(main_.entries.begin(), main_.entries, oldest);
      } else {
        ++figures_.evictions;
        remove(oldest, dropped);
      }
    }
  }

  void remove(Iterator at, std::vector<Pointer>& dropped) {
    dropped.push_back(std::move(at->value));
    Queue& queue = at->in_main ? main_ : small_;
    queue.bytes -= at->size;
    figures_.bytes -= at->size;
    index_.erase(at->key);
    queue.entries.erase(at);
  }

  void remember_ghost(const std::string& key) {
    if (!ghosts_.insert(key).second) return;
    ghost_order_.push_front(key);
    while (ghost_order_.size() > std::max(kMinGhosts, index_.size())) {
      ghosts_.erase(ghost_order_.back());
      ghost_order_.pop_back();
    }
  }
  /// Removes the key from the ghost list, and returns whether it was there. Its place in ghost_order_ is removed later, which
  /// does no harm.
  bool forget_ghost(const std::string& key) { return ghosts_.erase(key) > 0; }

  const std::size_t budget_;
  mutable std::mutex mutex_;
  Queue small_, main_;
  std::unordered_map<std::string, Iterator> index_;
  std::unordered_set<std::string> ghosts_;
  std::list<std::string> ghost_order_;  // newest first
  CacheFigures figures_;
};

}  // namespace fracture
