// The components of one owner's faces: what hangs together is one piece of volume.
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
  double volume = 0;  ///< only measured where an owner has several components
  bool has_caps = false;
  std::vector<std::vector<CutVertexId>> bodies{};  ///< as Piece::bodies
};

/// One owner's share of the restricted diagram.
struct OwnerShare {
  std::uint32_t owner;
  std::span<const Face> surface;            ///< its divided input triangles
  std::span<const FaceSource> caps;         ///< its sides of cap regions; regions inside the group once
  std::span<const std::uint32_t> polygons;  ///< its cells' polygons, for owners of several cells
};

/// Joins faces that share a vertex (ids are topology: faces that merely touch have different ids) and faces
/// along every cap region, suppressed ones too: so an annular cap joins its two rims, and a group's cells
/// hang together by volume. A component of negative volume without caps is a cavity's shell that no bisector
/// cuts; it joins the piece around it. Ordered by part, then by their first faces, which
/// neither rough cuts nor cells elsewhere change. Near-linear, also where a cell has thousands of islands and cavities.
/// Throws Interrupted.
std::vector<Component> find_components(const RestrictedDiagram& diagram, const Ownership& ownership,
                                       const OwnerShare& share, const Execution& execution = kUninterrupted);

}  // namespace fracture
