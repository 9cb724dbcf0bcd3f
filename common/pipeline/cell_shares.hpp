// Volume and centre of mass of each cell's share of the solid.
#pragma once

#include <optional>
#include <vector>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Volume and first moment of each cell's share, by the divergence theorem over its faces about a common
/// origin. The faces are input triangles, parts of them, and caps; a cap counts positively for one cell and
/// negatively for the other.
class CellShares {
 public:
  /// Takes time linear in triangles and caps. Throws Interrupted.
  CellShares(const RestrictedDiagram& diagram, const Execution& execution);

  double volume(SiteId site) const { return sum_[site].six_volume / 6; }  ///< m³; about 0 for an empty share
  /// Returns the centre of mass, or nothing if the share's volume is at most `least_volume`.
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
