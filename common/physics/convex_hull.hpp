// Convex hulls of a few to some thousand points, fast enough for the path to a frame: Quickhull (Barber,
// Dobkin & Huhdanpaa 1996) on points rounded to a grid of 2^19 steps along each side of their box. On the
// grid every orientation is exact in 64-bit integers, so the textbook algorithm needs no tolerance, cannot
// fail, and gives the same hull everywhere; the grid is 2e-6 of the box, far below what collision_hulls.hpp
// takes away.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

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
  const Triangles& build(std::span<const Vec3f> points, std::uint32_t max_points,
                         const Execution& execution = {});

  /// Whether the last hull had more than max_points.
  bool stopped_early() const { return stopped_early_; }

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
    std::uint32_t first_outside;  ///< head of the list of points above it that are not on the hull yet
    std::uint32_t stamp;          ///< the insertion that looked at it last
    bool visible;                 ///< from that point
    bool alive;
  };

  void round_to_grid(std::span<const Vec3f> points, Pacer& pacer);
  bool first_tetrahedron(Pacer& pacer);
  std::uint32_t add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Twice the area times the distance above the face's plane; exact.
  std::int64_t above(const Face& f, std::uint32_t p) const {
    const GridPoint& q = grid_[p];
    return f.normal.x * q.x + f.normal.y * q.y + f.normal.z * q.z - f.offset;
  }
  bool lexicographic_less(std::uint32_t a, std::uint32_t b) const;
  void put_outside(std::uint32_t p, std::uint32_t first_face, std::uint32_t end_face, Pacer& pacer);
  void insert_farthest(std::uint32_t face, Pacer& pacer);

  std::vector<GridPoint> grid_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> next_;           ///< of each point: the next of its face's list
  std::vector<std::uint32_t> new_face_from_;  ///< of each point: the new face whose horizon edge starts there
  std::vector<std::uint32_t> visible_, horizon_, pending_;
  std::uint32_t stamp_ = 0;
  bool stopped_early_ = false;
  Triangles triangles_;
};

}  // namespace fracture
