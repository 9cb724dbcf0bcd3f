// A filter that proves in single precision, with four bisectors at a time, that a point is in a given cell.
// Nearly all vertices of a mesh are in the same cell as their neighbour. Without the
// filter, testing each of them in double precision, one bisector at a time, would account for a tenth of the
// total time when a fracture makes few pieces.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

class CellFilter {
 public:
  /// Creates a filter for points in `box`. Throws Interrupted.
  CellFilter(const VoronoiDiagram& diagram, const Box& box, const Execution& execution);

  /// Returns true only if q is certainly nearer to site i than to any other site.
  bool surely_holds(SiteId i, const Vec3d& q) const {
    const std::uint32_t first = begin_[i], end = begin_[i + 1];
    if (first == end) return false;
    const Vec3d d = scale_ * (q - diagram_.site(i));
    const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y), z = static_cast<float>(d.z);
    Four least = bisectors_[first].value(x, y, z);
    for (std::uint32_t k = first + 1; k < end; ++k) {
      const Four value = bisectors_[k].value(x, y, z);
      least = value < least ? value : least;
    }
    return least[0] > 0 && least[1] > 0 && least[2] > 0 && least[3] > 0;
  }

 private:
  using Four = float __attribute__((vector_size(16)));  // g++ and clang++, on any processor
  /// Four bisectors, in units of the box: neighbour - site, and half its square minus the rounding bound.
  struct Bisectors {
    Four x, y, z, half;
    Four value(float qx, float qy, float qz) const { return half - (x * qx + y * qy + z * qz); }
  };

  const VoronoiDiagram& diagram_;
  double scale_ = 1;
  std::vector<std::uint32_t> begin_;  // per site, into bisectors_; cells with many neighbours have none
  std::vector<Bisectors> bisectors_;
};

}  // namespace fracture
