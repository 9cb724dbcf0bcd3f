// Convex hulls of a few to some thousand points, fast enough for a frame. Points are on a grid (hull_grid.hpp), where
// every orientation is exact in 64-bit integers. Bodies that are already convex use surface_hull.hpp. Others use
// Quickhull (Barber, Dobkin & Huhdanpaa 1996). On the grid it needs no tolerance, cannot fail, and gives the
// same hull on every machine.
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

/// Reuses its memory for the next hull. Each thread needs its own builder.
class ConvexHullBuilder {
 public:
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;

  /// Returns triangles of indices into `points` (finite), counter-clockwise from outside. Every corner is an extreme
  /// point of the rounded points; points within a facet are left out. If there are more than max_points (at least 4)
  /// extreme points, it is the hull of a well-spread selection of them, which lies within the full hull. Empty if
  /// the points are flat (within four steps of the grid, 1e-5 of the box) or fewer than four. Valid until the
  /// next call. Throws Interrupted.
  /// `tolerance`: corners that stick out of a face by less may be left out, so that a round body has only as many as its
  /// curvature needs. It is relative to the height of a tetrahedron of four far points: about half of the least width, never
  /// more than all of it. 0: all extreme points.
  /// `surface`: the triangles that enclose the body with these corners, if known. If they are convex except for
  /// rounding (surface_hull.hpp), they are the hull, or the hull is made of only those corners that stick out.
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
    std::int64_t least;           ///< points with above() at most this are ignored
    std::uint32_t first_outside;  ///< head of the list of points above it that are not on the hull yet
    std::uint32_t farthest;       ///< point of that list
    std::int64_t highest;         ///< above() of that point
    std::uint32_t stamp;          ///< the last insertion that visited this face
    bool visible;                 ///< from that insertion's point
    bool alive;
  };
  /// A visible face on the way around the horizon: its next edge, and the number of edges left.
  struct Step {
    std::uint32_t face;
    std::uint8_t edge, left;
  };
  struct HorizonEdge {
    std::uint32_t a, b, unseen;  ///< from a to b as in the visible face, and the face across
  };

  void quickhull(const std::array<std::uint32_t, 4>& first, std::uint32_t max_points, double tolerance,
                 Pacer& pacer);
  std::int64_t least_above(const GridPoint& normal) const;
  std::uint32_t add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Twice the face's area times the height of p above its plane; exact.
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
  std::vector<std::uint32_t> number_;  ///< if points were left out: per grid point, its given index
  // Used by Quickhull.
  std::vector<GridPoint> points_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> next_;  ///< for each point: the next one in its face's list
  std::vector<std::uint32_t> visible_, pending_;
  std::vector<Step> steps_;
  std::vector<HorizonEdge> horizon_;  ///< one cycle
  double tolerance_ = 0;              ///< in steps of the grid
  std::uint32_t stamp_ = 0;
  bool stopped_early_ = false;
  Triangles triangles_;
};

}  // namespace fracture
