// A map from a dense id space to uint32 that can be cleared in O(1), because each entry stores the epoch in
// which it was written. Used to find local indices of global ids for many small subsets of a large set.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/scratch.hpp"

namespace fracture {

class StampedMap {
 public:
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  /// Clears the map; from now on, ids must be < size.
  void next_epoch(std::size_t size) {
    if (entries_.size() < size) entries_.resize(size, {0, kEmpty});
    if (++epoch_ == 0) {
      for (Entry& e : entries_) e.epoch = 0;
      epoch_ = 1;
    }
  }
  std::size_t bytes() const { return bytes_of_vectors(entries_); }
  void release() { release_vectors(entries_); }
  /// The entry of id; kEmpty if nothing was stored since next_epoch().
  std::uint32_t& slot(std::size_t id) {
    Entry& e = entries_[id];
    if (e.epoch != epoch_) e = {epoch_, kEmpty};
    return e.value;
  }
  /// Returns the entry of id; if there is none, stores and returns `fresh`. Does not branch on whether there
  /// is an entry, because for the vertices of triangles the branch is unpredictable.
  std::uint32_t number(std::size_t id, std::uint32_t fresh) {
    Entry& e = entries_[id];
    const std::uint32_t known =
        0u - static_cast<std::uint32_t>((e.epoch == epoch_) & (e.value != kEmpty));  // all bits set, or 0
    const std::uint32_t value = (e.value & known) | (fresh & ~known);
    e = {epoch_, value};
    return value;
  }

 private:
  struct Entry {
    std::uint32_t epoch, value;
  };
  std::vector<Entry> entries_;
  std::uint32_t epoch_ = 0;
};

/// The calling thread's own map, kept between calls (scratch.hpp). Only one user at a time: next_epoch()
/// takes it over.
inline StampedMap& worker_map() { return thread_scratch<StampedMap>(); }

}  // namespace fracture
