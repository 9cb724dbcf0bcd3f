// Connected components of one owner's faces. Each component bounds one piece of the volume.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

struct Component {
  std::vector<Face> faces;
  std::uint32_t part = 0;
  double volume = 0;  ///< measured only if the owner has several components
  bool has_caps = false;
  std::vector<std::vector<CutVertexId>> bodies{};  ///< as Piece::bodies
};

/// One owner's share of the restricted diagram.
struct OwnerShare {
  std::uint32_t owner;
  std::span<const Face> surface;     ///< its divided input triangles
  std::span<const FaceSource> caps;  ///< its sides of cap regions; one side of regions inside the group
  std::span<const std::uint32_t> polygons;  ///< its cells' polygons, for owners of several cells
};

/// Finds the components of an owner's faces. Faces that share a vertex are joined (ids are topological:
/// faces that merely touch have different ids). So are the faces along every cap region, even along
/// suppressed ones: an annular cap joins its two rims, and the cells of a group are connected by volume. A
/// component of negative volume without caps is the shell of a cavity that no bisector cuts; it joins the
/// piece around it. The components are ordered by part, then by their first faces. Neither rough cuts nor
/// cells elsewhere change this order. Near-linear, even if a cell has thousands of islands and cavities.
/// Throws Interrupted.
std::vector<Component> find_components(const RestrictedDiagram& diagram, const Ownership& ownership,
                                       const OwnerShare& share, const Execution& execution = kUninterrupted);

}  // namespace fracture
