// A solid seen through the map of its cells. This image determines an anisotropic fracture.
#pragma once

#include <optional>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns the same surface (with the same vertex, triangle, edge and part ids) with its vertices mapped and
/// rounded once to float. Boxes, volumes, areas and layers are those of the image. It has no source, wedges,
/// materials or repair counts. Rounding may flatten triangles or fold them over one another, but the surface
/// stays closed. The map must not be the identity, and must have a positive determinant.
Solid image_of(const Solid& solid, const CellMap& map, const Execution& execution = {});

/// A solid and the surface that decides its cuts: its image under the map of the cells or, without a map, the
/// solid itself. Positions come from the original.
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
