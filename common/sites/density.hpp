// Density of sites painted on a mesh: how many sites a region gets depends on the colours or the material of
// the nearest surface.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture::sites_detail {

class Density {
 public:
  /// `from`: "COLOR_0" … "COLOR_7" is a set of vertex colours and uses their luminance: white regions get the
  /// most sites, black regions few. Otherwise, it is the name or number of a material of the source, and
  /// regions at its surface get the most sites. Triangles that are not in the source have no density. `solid`
  /// is borrowed, and has a source. Errors: kBadParameter (`density_from`) if there is no such colour set or
  /// material, or if it is nowhere on the solid. Throws Interrupted.
  static Expected<Density> make(const Solid& solid, const std::string& from, const Execution& execution);

  /// Density at a point in the solid's frame, relative to the maximum: kLeast … 1. Deterministic: if several
  /// triangles are equally near, the one with the lowest number is used.
  double at(const Vec3d& place, Pacer& pacer) const;

  /// Unpainted regions still break: their sites are about three times as far apart.
  static constexpr double kLeast = 1.0 / 32;

 private:
  struct Weighted {
    std::uint32_t triangle;
    std::array<double, 3> weight;  ///< at its corners
  };
  Density(const Solid& solid, std::vector<Weighted> triangles, const Execution& execution);

  const Solid* solid_;
  std::vector<Weighted> triangles_;
  BoxTree tree_;
  double slack_ = 0;  // m; more than the rounding error of a distance
};

}  // namespace fracture::sites_detail
