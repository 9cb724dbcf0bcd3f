// Limits on the size and number of fragments, and their effect.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fracture {

/// Zero means no limit. All limits are met by uniting the smallest fragment with the neighbour of largest
/// shared cap area.
struct SizeLimits {
  double min_volume = 0;    ///< m³
  double min_fraction = 0;  ///< of the solid's volume; the largest of the three limits applies
  double min_of_mean = 0;   ///< of the mean volume of the resulting fragments
  /// Requested number of fragments. Parts share them (part_quotas.hpp), and fragments beyond that are
  /// united. 0: all are kept.
  std::uint32_t fragments = 0;
  std::uint32_t max_fragments = 0;  ///< fragments without neighbours count, but cannot be united
  /// Maximum number of triangles in all fragments. A budget below the triangles of the uncut solid cannot
  /// be met; then nothing is united.
  std::uint64_t max_triangles = 0;
  /// Per part: pieces in it count as this many times as large when pieces are compared with each other and
  /// with the mean. So pieces of thin parts that are hit stay (sites/part_shares.hpp). Empty: all count as they
  /// are. min_volume, min_fraction and max_triangles always concern the pieces as they are.
  std::vector<double> weights{};
  /// The owner of the cells in a kept region: its pieces never merge with a neighbour, and another piece merges
  /// with them only if it has no other neighbour. kNoOwner: none.
  std::uint32_t kept_owner = kNoOwner;
  static constexpr std::uint32_t kNoOwner = 0xffffffffu;

  bool any_least() const { return min_volume > 0 || min_fraction > 0 || min_of_mean > 0; }
  /// Minimum volume, m³, for `count` fragments of a solid of this volume.
  double least(double volume, std::uint32_t count) const {
    // The mean is that of the fragments that will remain.
    if (fragments > 0) count = std::min(count, fragments);
    return std::max({min_volume, min_fraction * volume, min_of_mean * volume / count});
  }
  bool any() const { return any_least() || fragments > 0 || max_fragments > 0 || max_triangles > 0; }
  bool operator==(const SizeLimits&) const = default;
};

/// A piece is inside out if its volume is below minus this share of the solid's volume. Rounding is far smaller.
inline constexpr double kInsideOut = 1e-9;

/// Effect of the limits.
struct SizeFigures {
  /// Pieces that became part of another one, because of a limit or because pieces of several parts in one cell were joined.
  std::uint32_t united = 0;
  /// Pieces of negative volume: the surface crosses itself there and turns inside out. They are united with a neighbour too, with
  /// or without limits.
  std::uint32_t inside_out = 0;
  std::uint32_t alone = 0;  ///< pieces below the minimum volume that stay, because they touch no other
  /// Parts of the solid, or groups of parts that hold together and share fragments; 0 unless SizeLimits::fragments is set.
  std::uint32_t parts = 0;
  double min_volume = 0;  ///< m³, the minimum volume that was applied
  /// The fewest triangles that uniting can reach; counted only if max_triangles is set.
  std::uint64_t fewest_triangles = 0;
  bool operator==(const SizeFigures&) const = default;
};

}  // namespace fracture
