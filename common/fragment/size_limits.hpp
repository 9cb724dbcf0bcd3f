// How small a fragment may be, and how many there may be: what is asked, and what was made of it.
#pragma once

#include <algorithm>
#include <cstdint>

namespace fracture {

/// Zero: no limit. All are met by uniting the smallest fragment with the neighbour of largest shared cap
/// area.
struct SizeLimits {
  double min_volume = 0;    ///< m³
  double min_fraction = 0;  ///< of the solid's volume; the largest of the three counts
  double min_of_mean = 0;   ///< of the mean volume of the fragments that are made
  /// So many are wanted: parts share them (part_quotas.hpp), and what there is beyond that is united. 0: all.
  std::uint32_t fragments = 0;
  std::uint32_t max_fragments = 0;  ///< fragments that no other touches count, but cannot be united
  /// Triangles of all fragments. A budget below what the solid has when nothing is cut cannot be met; then it
  /// unites nothing.
  std::uint64_t max_triangles = 0;

  bool any_least() const { return min_volume > 0 || min_fraction > 0 || min_of_mean > 0; }
  /// m³: smaller fragments are too small where there are so many, of a solid of this volume.
  double least(double volume, std::uint32_t count) const {
    // What is small beside the mean is small beside that of the fragments there will be.
    if (fragments > 0) count = std::min(count, fragments);
    return std::max({min_volume, min_fraction * volume, min_of_mean * volume / count});
  }
  bool any() const { return any_least() || fragments > 0 || max_fragments > 0 || max_triangles > 0; }
  bool operator==(const SizeLimits&) const = default;
};

/// What the limits did.
struct SizeFigures {
  std::uint32_t united = 0;  ///< pieces that became part of another, because of a limit or of `joined`
  std::uint32_t joined = 0;  ///< pieces that became part of a piece of another part in their cell
  std::uint32_t alone = 0;   ///< pieces below the smallest volume that touch no other: they stay
  /// Parts of the solid, or groups of parts that hold together and share fragments; 0 unless SizeLimits::fragments is set.
  std::uint32_t parts = 0;
  double min_volume = 0;  ///< m³, the smallest volume in force
  /// The fewest triangles that uniting can reach; only counted where max_triangles is set.
  std::uint64_t fewest_triangles = 0;
  bool operator==(const SizeFigures&) const = default;
};

}  // namespace fracture
