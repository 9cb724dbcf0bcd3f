// Do caps pass through one another or through the outer surface? Judged on where their vertices are now, pair by
// pair, by what makes two triangles cross: an edge of one that pierces the inside of the other. Triangles of one
// region do not while each looks the way its facet does: whoever moves them has to see to that (of slivers, which
// have no side, nobody does).
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
  const std::vector<std::uint32_t>&
      region_begin;                  ///< the first triangle of each region, and how many there are
  const std::vector<char>& seen;     ///< per triangle: 0 where it lies inside a fragment and is no cut
  CutVertexId first;                 ///< the vertex of points[0]
  const std::vector<Vec3d>& points;  ///< where they are
  const std::vector<Vec3d>& flat;    ///< where they were
  const std::vector<char>& moved;    ///< per point: not where it was
  const std::vector<double>&
      surface;  ///< per point: how far the flat one is from the outer surface, up to some reach
  const std::vector<std::uint32_t>& place;  ///< per point: equal where flat ones coincide
  /// The triangles from here on are in the way of the others; what they do among themselves and with the outer
  /// surface is not asked.
  std::uint32_t first_given;
};

/// Indices of two triangles that cross, or of one, twice, that does not lie as it should: for other reasons than
/// another.
using CrossingPair = std::array<std::uint32_t, 2>;

/// Keeps references: what the caps are made of may change between two looks.
class Crossings {
 public:
  /// Pairs that cross by `tolerance` (m) or less do not count. Throws Interrupted.
  Crossings(const CapSurface& caps, const SurfaceTree& outside, double tolerance,
            const Execution& execution = {});

  /// How many pairs cross and could do otherwise: they have a moved vertex. Sets `crossing` (per triangle) of
  /// both. The first time all pairs are looked at, later only those with one of the `suspects` (per
  /// triangle), which are the triangles whose vertices have been moved since. Nothing when too many lie in
  /// each other's boxes (slivers as long as the mesh, movements as large as its pieces): kMostPairs for each
  /// triangle, all looks together. `named`, if not null, gets those pairs, in any order; the first kMostNamed of a
  /// look.
  std::optional<std::uint64_t> find(const std::vector<char>& suspects, std::vector<char>& crossing,
                                    const Execution& execution, std::vector<CrossingPair>* named = nullptr);
  static constexpr std::uint64_t kMostPairs = 300;
  static constexpr std::size_t kMostNamed = 1 << 16;
  /// Of which boxes met, in all looks.
  std::uint64_t pairs() const { return pairs_; }

 private:
  // These take indices of `seen_`.
  const std::array<CutVertexId, 3>& vertices(std::uint32_t k) const { return caps_.triangles[seen_[k]]; }
  PlaneTriangle as_it_is(std::uint32_t k) const;
  bool is_moved(std::uint32_t k) const;
  /// Leaves pairs out that could do nothing about it, share a side, or are of one region.
  bool pair_crosses(std::uint32_t i, std::uint32_t j) const;
  bool may_leave_surface(std::uint32_t k) const;
  struct SurfaceBeside {
    std::vector<std::uint32_t> may_leave;  // of the caps
    std::vector<std::uint32_t> triangles;  // of the outer surface
    std::vector<Box> boxes;                // of these
  };
  static constexpr std::size_t kFewBeside = 64;       // of which asking each is cheaper than asking the tree
  static constexpr std::size_t kFewOutside = 20'000;  // of which looking for these takes no time to speak of
  static constexpr std::uint32_t kFewMoved = 4;       // one of so many triangles, at most
  template <class Leaves>
  void each_leaving(std::span<const std::uint32_t> triangles, SurfaceBeside& beside,
                    const Leaves& leaves) const;

  const CapSurface caps_;
  const SurfaceTree& outside_;
  const double tolerance_;
  std::vector<std::uint32_t> seen_;    // the triangles that are
  std::vector<std::uint32_t> region_;  // of each of them
  std::vector<PlaneTriangle> now_;     // per triangle of `seen_`, as it is
  std::vector<Box> boxes_;             // the same
  BoxTree tree_;                       // of the boxes
  bool looked_ = false;
  std::uint64_t pairs_ = 0;
};

}  // namespace fracture
