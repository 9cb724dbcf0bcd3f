// Points that surely lie in a cell of the diagram, told in single precision from four bisectors at a time. Nearly all
// vertices of a mesh lie in the cell of their neighbour on it, and to see that each in doubles, a bisector at a time,
// takes a tenth of a fracture into few pieces.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

class CellFilter {
 public:
  /// For points in `box`. Throws Interrupted.
  CellFilter(const VoronoiDiagram& diagram, const Box& box, const Execution& execution);

  /// True only where q is nearer to site i than to any other one, for sure.
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
  using Four = float __attribute__((vector_size(16)));  // g++ and clang++, of any processor
  /// Of four bisectors, in units of the box: the neighbour less the site, and half its square less what rounding may do.
  struct Bisectors {
    Four x, y, z, half;
    Four value(float qx, float qy, float qz) const { return half - (x * qx + y * qy + z * qz); }
  };

  const VoronoiDiagram& diagram_;
  double scale_ = 1;
  std::vector<std::uint32_t> begin_;  // into bisectors_, of each site; cells of many neighbours have none
  std::vector<Bisectors> bisectors_;
};

}  // namespace fracture
