#include "common/fragment/piece_groups.hpp"

#include <algorithm>
#include <numeric>

namespace fracture {
namespace {

constexpr std::uint64_t kMissedCache = 8;  // steps, because the members of a group are far apart in memory

}  // namespace

PieceGroups::PieceGroups(std::size_t pieces) : set_(pieces), size_(pieces, 1) {
  std::iota(set_.begin(), set_.end(), 0u);
  next_ = name_ = set_;
}

std::vector<std::uint32_t> PieceGroups::members(std::uint32_t group, const Execution& execution) const {
  Pacer pacer(execution);
  std::vector<std::uint32_t> all{group};
  all.reserve(size(group));
  for (std::uint32_t p = next_[group]; p != group; p = next_[p]) {
    pacer.step(kMissedCache);
    all.push_back(p);
  }
  sort_with_polls(execution, all.begin(), all.end());
  return all;
}

std::vector<std::uint32_t> PieceGroups::names() const {
  std::vector<std::uint32_t> all(set_.size());
  for (std::uint32_t p = 0; p < all.size(); ++p) all[p] = of(p);
  return all;
}

PieceGroups::Union PieceGroups::unite(std::uint32_t a, std::uint32_t b, Pacer& pacer) {
  std::uint32_t kept = set_[a], gone = set_[b];
  if (kept == gone) return {kept, gone};
  if (size_[kept] < size_[gone]) {
    std::swap(kept, gone);
    std::swap(a, b);
  }
  std::uint32_t p = b;
  do {
    pacer.step(kMissedCache);
    set_[p] = kept;
    p = next_[p];
  } while (p != b);
  std::swap(next_[a], next_[b]);  // two circles become one
  name_[kept] = std::min(name_[kept], name_[gone]);
  size_[kept] += size_[gone];
  return {kept, gone};
}

}  // namespace fracture
