// The volumes that fragments should have: Weibull's distribution ("A statistical distribution function of wide
// applicability", 1951), in numbers of fragments:
//
//   N(> v) / N = exp(-(v / scale)^(1 / spread))
//
// spread 0: all fragments have the same volume.
// spread 1: the exponential distribution of Grady & Kipp ("Geometric statistics and dynamic fragmentation",
//   J. Appl. Phys. 58, 1985), which describes the large fragments of a Poisson process of cracks. Åström, Ouchterlony,
//   Linna & Timonen ("Universal dynamic fragmentation in D dimensions", Phys. Rev. Lett. 92, 245506, 2004) find it in
//   quarry blasts and in the crushing of granitic gneiss, together with a power law for fines. Fines are dust here and
//   are not made.
// spread 2: the distribution of Mott & Linfoot (1943).
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <set>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// Returns `count` volumes as fractions of their sum, ascending: the quantiles at the middles of equal
/// shares of probability. So their own distribution deviates by at most 1 / (2 count). The same bits on
/// every platform.
std::vector<double> fragment_sizes(std::uint32_t count, double spread, Pacer& pacer);

/// The sizes that no fragment has taken yet.
class SizesLeft {
 public:
  /// `least`: minimum size, m³.
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
  /// m³, scaled so that the remaining sizes fill the remaining part of the solid.
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
  /// Notes that this volume was used for something other than one of the sizes.
  void lose(double volume) { volume_ -= volume; }

 private:
  double scale() const { return sum_ > 0 && volume_ > 0 ? volume_ / sum_ : 0; }

  std::vector<double> sizes_;  // ascending
  std::set<std::uint32_t> left_;
  double volume_, sum_ = 0;  // of the remaining sizes
};

}  // namespace fracture
