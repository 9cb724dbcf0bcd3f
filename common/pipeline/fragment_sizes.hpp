// The volumes that fragments are to have: Weibull's distribution ("A statistical distribution function of wide
// applicability", 1951), in numbers of fragments:
//
//   N(> v) / N = exp(-(v / scale)^(1 / spread))
//
// spread 0: all alike. 1: the exponential distribution of Grady & Kipp ("Geometric statistics and dynamic
// fragmentation", J. Appl. Phys. 58, 1985), the large fragments of a Poisson process of cracks; Åström, Ouchterlony,
// Linna & Timonen ("Universal dynamic fragmentation in D dimensions", Phys. Rev. Lett. 92, 245506, 2004) find it in
// quarry blasts and in the crushing of granitic gneiss, beside a power law of fines, which here are dust: nobody makes
// them. 2: that of Mott & Linfoot (1943).
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <set>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// `count` volumes as parts of their sum, ascending: the quantiles in the middles of equal shares of probability, so that
/// their own distribution is off by no more than 1 / (2 count). The same bits everywhere.
std::vector<double> fragment_sizes(std::uint32_t count, double spread, Pacer& pacer);

/// The sizes that no fragment has yet.
class SizesLeft {
 public:
  /// `least`: m³, below which none is to be.
  SizesLeft(std::uint32_t count, double spread, double volume, double least, Pacer& pacer)
      : sizes_(fragment_sizes(count, spread, pacer)), volume_(volume) {
    for (std::uint32_t k = 0; k < count; ++k) {
      sizes_[k] = std::max(sizes_[k], least / volume);
      sum_ += sizes_[k];
      left_.insert(left_.end(), k);
    }
  }

  std::uint32_t left() const { return static_cast<std::uint32_t>(left_.size()); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(sizes_.size()); }
  double part(std::uint32_t rank) const { return sizes_[rank]; }
  /// m³, so that what is left of them fills what is left of the solid.
  double volume(std::uint32_t rank) const { return sizes_[rank] * scale(); }

  std::uint32_t smallest() const { return *left_.begin(); }
  std::uint32_t nearest_rank(std::uint32_t rank) const {
    const auto above = left_.lower_bound(rank);
    if (above == left_.begin()) return *above;
    const std::uint32_t below = *std::prev(above);
    return above == left_.end() || rank - below < *above - rank ? below : *above;
  }
  std::uint32_t nearest_size(double volume) const {
    const auto at = std::lower_bound(sizes_.begin(), sizes_.end(), volume / scale());
    const auto above = left_.lower_bound(static_cast<std::uint32_t>(at - sizes_.begin()));
    if (above == left_.begin()) return *above;
    const std::uint32_t below = *std::prev(above);
    return above == left_.end() || volume - this->volume(below) < this->volume(*above) - volume ? below
                                                                                                : *above;
  }
  void use(std::uint32_t rank, double volume) {
    left_.erase(rank);
    sum_ -= sizes_[rank];
    volume_ -= volume;
  }
  /// Has gone elsewhere than to one of the sizes.
  void lose(double volume) { volume_ -= volume; }

 private:
  double scale() const { return sum_ > 0 && volume_ > 0 ? volume_ / sum_ : 0; }

  std::vector<double> sizes_;  // ascending
  std::set<std::uint32_t> left_;
  double volume_, sum_ = 0;  // of what is left
};

}  // namespace fracture
