// A copy of a solid's source that also has the inner sides of walls: their wedges and triangles stand behind its own.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/hollow/inner_surface.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::hollow_detail {

/// Of one triangle, by its corners.
std::array<Vec3d, 3> corners_of(const InnerSurface& surface, std::size_t triangle);

class ExtendedSource {
 public:
  /// With room for so many more. Counts what the copy takes (Product::kMeshBytes). Throws Interrupted.
  ExtendedSource(const Mesh& source, std::size_t wedges, std::size_t triangles, const Execution& execution);

  /// A wedge for each corner, whose numbers follow the one that is returned: its normal is the mean by area; it
  /// has no texture and is white.
  std::uint32_t add_wedges(const InnerSurface& surface);
  /// Of kCavityMaterial, in the node and with the colour of the part.
  void add_triangle(const std::array<std::uint32_t, 3>& wedges, const Part& part);

  std::shared_ptr<const Mesh> finished() && { return std::move(mesh_); }

 private:
  std::shared_ptr<Mesh> mesh_;
  Pacer pacer_;
};

}  // namespace fracture::hollow_detail
