// L0: a cache of shared immutable values in memory, with a budget in bytes. One pass over many values that
// are asked for once (a crawler, a batch of new seeds) does not displace those that are asked for again and
// again.
//
// S3-FIFO (Yang, Zhang, Qiu, Yue, Vigfusson, "FIFO queues are all you need for cache eviction", SOSP 2023):
//
//              miss          asked for again               asked for since
//     key ───────────> small ────────────────> main <───┐ ──────────────── (goes round once more)
//      │               10 % │ not asked again    │ └────┘
//      │                    v                    v not asked for
//      │                  ghost (keys only)     gone
//      └── in ghost ────────────────────────> main
//
// We depart from the paper in counting bytes rather than objects, and in promoting from `small` after one
// further request instead of two: an answer that was asked for twice is worth more than one that was not, and
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

/// Invariants: bytes is the sum of the sizes of the entries and at most the budget; every entry stands in one
/// queue and in the index; no key is in the index and in the ghost. Who still holds an evicted value keeps it
/// alive. Thread-safe.
template <class Value>
class MemoryCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  explicit MemoryCache(std::size_t budget) : budget_(budget) {}

  /// find() for a second look, which counts nothing.
  Pointer peek(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    return at == index_.end() ? nullptr : at->second->value;
  }
  /// What the entry was said to take when it was inserted; nothing when it is absent.
  std::optional<std::size_t> size_of(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    return at == index_.end() ? std::nullopt : std::optional(at->second->size);
  }
  /// Null when absent.
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

  /// False, and nothing changes, when the value alone is over the budget. An entry of the same key is
  /// replaced.
  bool insert(const std::string& key, Pointer value, std::size_t size) {
    if (size > budget_) return false;
    std::vector<Pointer>
        dropped;  // freed without the lock: io threads wait for it, and large values take a while
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
  static constexpr std::size_t kSmallShare = 10;   // small is 1/10 of the budget
  static constexpr std::size_t kMinGhosts = 1024;  // keys of 64 digits: 100 KB

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

  /// Looks at the oldest entry of the queue that is over its share: evicts it, or gives it another turn. Each
  /// turn costs a use, so that finitely many calls free something.
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
  /// True when the key was there. Its place in the order stays until it is its turn: harmless.
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
