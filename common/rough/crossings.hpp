// Finds caps that pass through one another or through the outer surface. Works pair by pair, on the current
// positions of the vertices: two triangles cross if an edge of one pierces the interior of the other.
// Triangles of one region do not cross if each faces the same way as its facet. The caller must ensure this;
// for slivers, which have no definite side, nobody does.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/bvh/triangle_crossing.hpp"
#include "common/clip/caps.hpp"

namespace fracture {

struct CapSurface {
  const std::vector<std::array<CutVertexId, 3>>& triangles;
  /// The first triangle of each region, then the number of triangles
  const std::vector<std::uint32_t>& region_begin;
  const std::vector<char>& seen;     ///< per triangle: 0 if it is inside a fragment and not part of a cut
  CutVertexId first;                 ///< the vertex at points[0]
  const std::vector<Vec3d>& points;  ///< current positions
  const std::vector<Vec3d>& flat;    ///< original positions
  const std::vector<char>& moved;    ///< per point: whether it has left its original position
  /// Per point: distance of its original position to the outer surface, up to some maximum
  const std::vector<double>& surface;
  const std::vector<std::uint32_t>& place;  ///< per point: equal for points whose original positions coincide
};

/// Keeps references, because the caps may change between two calls of find().
class Crossings {
 public:
  /// Crossings of at most `tolerance` (m) are ignored. Throws Interrupted.
  Crossings(const CapSurface& caps, const SurfaceTree& outside, double tolerance,
            const Execution& execution = {});

  /// Returns the number of pairs that cross and have a moved vertex, and sets `crossing` (per triangle) for
  /// both triangles. The first call tests all pairs. Later calls test only pairs with one of the `suspects`
  /// (per triangle), which are the triangles whose vertices have moved since. Returns nothing if all calls
  /// together test more than kMostPairs per triangle, because too many boxes overlap (slivers as long as the
  /// mesh, movements as large as its pieces).
  std::optional<std::uint64_t> find(const std::vector<char>& suspects, std::vector<char>& crossing,
                                    const Execution& execution);
  static constexpr std::uint64_t kMostPairs = 300;

 private:
  // The following functions take indices of `seen_`.
  const std::array<CutVertexId, 3>& vertices(std::uint32_t k) const { return caps_.triangles[seen_[k]]; }
  PlaneTriangle as_it_is(std::uint32_t k) const;
  bool is_moved(std::uint32_t k) const;
  /// Ignores pairs that have no moved vertex, share an edge, or are in one region.
  bool pair_crosses(std::uint32_t i, std::uint32_t j) const;
  bool may_leave_surface(std::uint32_t k) const;
  struct SurfaceBeside {
    std::vector<std::uint32_t> may_leave;  // indices of cap triangles
    std::vector<std::uint32_t> triangles;  // triangles of the outer surface nearby
    std::vector<Box> boxes;                // boxes of `triangles`
  };
  static constexpr std::size_t kFewBeside = 64;       // up to this many, testing each is cheaper
  static constexpr std::size_t kFewOutside = 20'000;  // up to this many, finding those nearby is cheap
  static constexpr std::uint32_t kFewMoved = 4;       // if fewer than 1 / this have moved, each queries tree_
  template <class Leaves>
  void each_leaving(std::span<const std::uint32_t> triangles, SurfaceBeside& beside,
                    const Leaves& leaves) const;

  const CapSurface caps_;
  const SurfaceTree& outside_;
  const double tolerance_;
  std::vector<std::uint32_t> seen_;    // indices of the triangles that count
  std::vector<std::uint32_t> region_;  // region of each of them
  std::vector<PlaneTriangle> now_;     // per triangle of `seen_`: its current state
  std::vector<Box> boxes_;             // per triangle of `seen_`
  BoxTree tree_;                       // tree over boxes_
  bool looked_ = false;
  std::uint64_t pairs_ = 0;
};

}  // namespace fracture
