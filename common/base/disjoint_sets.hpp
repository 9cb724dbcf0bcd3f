// Union-find (Tarjan 1975, path halving).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fracture {

/// Disjoint sets whose root is always the lowest member, so that results do not depend on the order of
/// unions.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) : parent_(count), sets_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }
  std::size_t size() const { return parent_.size(); }
  std::size_t bytes() const { return parent_.capacity() * sizeof(parent_[0]); }
  /// Number of sets.
  std::size_t set_count() const { return sets_; }
  void clear() {
    parent_.clear();
    sets_ = 0;
  }
  void reserve(std::size_t count) { parent_.reserve(count); }
  /// Adds a new member, in its own set.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    ++sets_;
    return parent_.back();
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    if (parent_[a] == parent_[b]) return;  // the usual case
    a = find(a);
    b = find(b);
    if (a == b) return;
    --sets_;
    if (a < b)
      parent_[b] = a;
    else
      parent_[a] = b;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::size_t sets_;
};

}  // namespace fracture
