// A solid seen through a linear map: what decides an anisotropic fracture.
#pragma once

#include <optional>

#include "common/base/execution.hpp"
#include "common/base/matrix3.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The same surface (vertex, triangle, edge and part ids) with its vertices at map · position, rounded once
/// to float; boxes, volumes, areas and layers are those of the image. Has no source, wedges, materials or
/// repair figures. Rounding may make triangles flat or fold over one another: the surface stays closed.
/// The map's determinant must be positive.
Solid image_of(const Solid& solid, const Matrix3& map, const Execution& execution = {});

/// A solid and what decides how it is cut: its image under the map of the cells, or, without one, itself. The
/// image decides, the original has the positions.
class SeenSolid {
 public:
  /// `original` is borrowed.
  explicit SeenSolid(const Solid& original) : original_(&original) {}
  SeenSolid(const Solid& original, const std::optional<Matrix3>& map, const Execution& execution)
      : original_(&original), map_(map) {
    if (map) image_ = image_of(original, *map, execution);
  }

  const Solid& original() const { return *original_; }
  const Solid& seen() const { return image_ ? *image_ : *original_; }
  const std::optional<Matrix3>& map() const { return map_; }

 private:
  const Solid* original_;
  std::optional<Matrix3> map_{};
  std::optional<Solid> image_{};
};

}  // namespace fracture
