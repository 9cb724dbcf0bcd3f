// Convex hulls of a few to some thousand points, fast enough for the path to a frame: on a grid (hull_grid.hpp), where
// every orientation is exact in 64-bit integers. The corners of a body that is convex already: surface_hull.hpp.
// Others: Quickhull (Barber, Dobkin & Huhdanpaa 1996), which there needs no tolerance, cannot fail, and gives the
// same hull everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"
#include "common/physics/hull_grid.hpp"
#include "common/physics/surface_hull.hpp"

namespace fracture {

/// Keeps its memory from one hull to the next: one builder for each thread.
class ConvexHullBuilder {
 public:
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;

  /// Triangles of indices into `points` (finite), counter-clockwise from outside; every corner is an extreme
  /// point of the rounded points, those within a facet are left out. With more than max_points (at least 4)
  /// extreme points, the hull of a well-spread choice of them, which lies within the whole one. Empty when
  /// the points are flat (within four steps of the grid, 1e-5 of the box) or fewer than four. Valid until the
  /// next call. Throws Interrupted.
  /// `tolerance`, of the height of a tetrahedron of four far points (half of the least width, about, and at most all of
  /// it): corners that stick out of a face by less may be left out, so that what is round has as many as its bend needs.
  /// 0: all extreme points.
  /// `surface`: where known, the triangles that enclose the body whose corners the points are. Where they are
  /// convex but for rounding (surface_hull.hpp) they are the hull, or its corners those of them that stick out.
  const Triangles& build(std::span<const Vec3f> points, std::uint32_t max_points,
                         const Execution& execution = {}, const BodySurface& surface = {},
                         double tolerance = 0);

  /// Whether the last hull had more than max_points.
  bool stopped_early() const { return stopped_early_; }

  std::size_t bytes() const {
    return grid_.bytes() + surface_.bytes() +
           bytes_of_vectors(number_, points_, faces_, next_, visible_, pending_, steps_, horizon_,
                            triangles_);
  }
  void release() {
    grid_.release();
    surface_.release();
    release_vectors(number_, points_, faces_, next_, visible_, pending_, steps_, horizon_, triangles_);
  }

 private:
  struct GridPoint {
    std::int64_t x, y, z;  ///< in [0, 2^19)
  };
  /// A triangle; edge k runs from v[k] to v[(k + 1) % 3], and neighbour[k] lies across it.
  struct Face {
    std::array<std::uint32_t, 3> v;
    std::array<std::uint32_t, 3> neighbour;
    GridPoint normal;             ///< |component| < 2^39
    std::int64_t offset;          ///< of the plane: dot(normal, v[0]) < 3 * 2^58
    std::int64_t least;           ///< above() of what is no higher is nothing
    std::uint32_t first_outside;  ///< head of the list of points above it that are not on the hull yet
    std::uint32_t farthest;       ///< of them
    std::int64_t highest;         ///< above() that one
    std::uint32_t stamp;          ///< the insertion that looked at it last
    bool visible;                 ///< from that point
    bool alive;
  };
  /// A visible face on the way around the horizon: the edge to look at next, and how many are left.
  struct Step {
    std::uint32_t face;
    std::uint8_t edge, left;
  };
  struct HorizonEdge {
    std::uint32_t a, b, unseen;  ///< from a to b as the visible face has it, and the face across
  };

  void quickhull(const std::array<std::uint32_t, 4>& first, std::uint32_t max_points, double tolerance,
                 Pacer& pacer);
  std::int64_t least_above(const GridPoint& normal) const;
  std::uint32_t add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Twice the area times the distance above the face's plane; exact.
  std::int64_t above(const Face& f, std::uint32_t p) const {
    const GridPoint& q = points_[p];
    return f.normal.x * q.x + f.normal.y * q.y + f.normal.z * q.z - f.offset;
  }
  bool lexicographic_less(std::uint32_t a, std::uint32_t b) const;
  void put_outside(std::uint32_t p, std::uint32_t first_face, std::uint32_t end_face, Pacer& pacer);
  void find_horizon(std::uint32_t face, std::uint32_t p);
  void insert_farthest(std::uint32_t face, Pacer& pacer);

  HullGrid grid_;
  SurfaceHull surface_;
  std::vector<std::uint32_t> number_;  ///< of the grid's points, where these are not all: among those given
  // Of Quickhull.
  std::vector<GridPoint> points_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> next_;  ///< of each point: the next of its face's list
  std::vector<std::uint32_t> visible_, pending_;
  std::vector<Step> steps_;
  std::vector<HorizonEdge> horizon_;  ///< one cycle
  double tolerance_ = 0;              ///< in steps of the grid
  std::uint32_t stamp_ = 0;
  bool stopped_early_ = false;
  Triangles triangles_;
};

}  // namespace fracture
