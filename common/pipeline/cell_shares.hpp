// What each cell has of the solid: its volume and the middle of it.
#pragma once

#include <optional>
#include <vector>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Volume and first moment of each cell's share, by the divergence theorem over its faces about a common
/// origin: input triangles and their parts, and caps, which count for one cell and against the other.
class CellShares {
 public:
  /// Linear in triangles and caps. Throws Interrupted.
  CellShares(const RestrictedDiagram& diagram, const Execution& execution);

  double volume(SiteId site) const { return sum_[site].six_volume / 6; }  ///< m³; 0 or so: it has none
  /// Nothing for a share without volume.
  std::optional<Vec3d> center(SiteId site, double least_volume) const;

 private:
  void add(SiteId site, double sign, const Vec3d& p, const Vec3d& q, const Vec3d& r);

  struct Sum {
    double six_volume = 0;
    Vec3d moment;
  };
  std::vector<Sum> sum_;
  Vec3d origin_;
};

}  // namespace fracture
