// Where a mesh is painted to break: how many sites a place gets, by the colours or the material of the surface nearest
// to it.
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
  /// `from`: "COLOR_0" … "COLOR_7", a set of vertex colours (their luminance: white has all sites, black few), or a
  /// material of the source by its name or number (its surface has all). Of triangles that the source has not nothing is
  /// known. `solid` is borrowed, and has a source. Errors: kBadParameter (`density_from`): there is no such thing, or
  /// nothing of it on the solid. Throws Interrupted.
  static Expected<Density> make(const Solid& solid, const std::string& from, const Execution& execution);

  /// Of the place of the solid's frame, relative to the most that there is: kLeast … 1. Deterministic: of surfaces that
  /// are as near, the triangle of the lowest number counts.
  double at(const Vec3d& place, Pacer& pacer) const;

  /// What is not painted breaks, too: sites are a third as close there.
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
  double slack_ = 0;  // m, more than rounding does to a distance
};

}  // namespace fracture::sites_detail
