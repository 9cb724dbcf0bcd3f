// A solid seen through the map of its cells: what decides an anisotropic fracture.
#pragma once

#include <optional>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The same surface (vertex, triangle, edge and part ids) with its vertices where the map has them, rounded once
/// to float; boxes, volumes, areas and layers are those of the image. Has no source, wedges, materials or
/// repair figures. Rounding may make triangles flat or fold over one another: the surface stays closed.
/// The map is not the identity, and its determinant is positive.
Solid image_of(const Solid& solid, const CellMap& map, const Execution& execution = {});

/// A solid and what decides how it is cut: its image under the map of the cells, or, without one, itself. The
/// image decides, the original has the positions.
class SeenSolid {
 public:
  /// `original` is borrowed.
  explicit SeenSolid(const Solid& original) : original_(&original) {}
  SeenSolid(const Solid& original, const CellMap& map, const Execution& execution)
      : original_(&original), map_(map) {
    if (map) image_ = image_of(original, map, execution);
  }

  const Solid& original() const { return *original_; }
  const Solid& seen() const { return image_ ? *image_ : *original_; }
  const CellMap& map() const { return map_; }

 private:
  const Solid* original_;
  CellMap map_{};
  std::optional<Solid> image_{};
};

}  // namespace fracture
