// A copy of a solid's source, extended by the inner sides of walls: their wedges and triangles follow those
// of the source.
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

/// The corners of one triangle.
std::array<Vec3d, 3> corners_of(const InnerSurface& surface, std::size_t triangle);

class ExtendedSource {
 public:
  /// Makes a copy with room for additional wedges and triangles. Counts its memory (Product::kMeshBytes).
  /// Throws Interrupted.
  ExtendedSource(const Mesh& source, std::size_t wedges, std::size_t triangles, const Execution& execution);

  /// Adds a wedge for each position, and returns the number of the first. Normals are means, weighted by
  /// area. The wedges have no texture and are white.
  std::uint32_t add_wedges(const InnerSurface& surface);
  /// Adds a triangle with kCavityMaterial, and with the node and colour of the part.
  void add_triangle(const std::array<std::uint32_t, 3>& wedges, const Part& part);

  std::shared_ptr<const Mesh> finished() && { return std::move(mesh_); }

 private:
  std::shared_ptr<Mesh> mesh_;
  Pacer pacer_;
};

}  // namespace fracture::hollow_detail
