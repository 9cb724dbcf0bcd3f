// The hull of a body that is convex except for rounding, as most fragments are, is its own surface. A few tests per
// edge are faster than a general hull algorithm, and bodies that are not convex are recognized early.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/physics/hull_grid.hpp"

namespace fracture {

/// Triangles between the corners of a body, counter-clockwise from outside; borrowed. Empty if the surface is not known.
class BodySurface {
 public:
  BodySurface() = default;
  /// `indices`: three vertices per triangle. `corner_of`: for each vertex, the corner at its position. `uncut`: number of
  /// triangles at the beginning that may bend inwards among themselves, if that is known and the surface is closed. The other
  /// triangles are then cuts, which are faces of a convex cell.
  BodySurface(std::span<const std::uint32_t> indices, std::span<const std::uint32_t> corner_of,
              std::optional<std::size_t> uncut = {})
      : indices_(indices), corner_of_(corner_of.data()), uncut_(uncut) {}

  std::size_t size() const { return indices_.size() / 3; }
  std::optional<std::size_t> uncut() const { return uncut_; }
  std::array<std::uint32_t, 3> operator[](std::size_t triangle) const {
    const std::uint32_t* const v = indices_.data() + 3 * triangle;
    return {corner_of_[v[0]], corner_of_[v[1]], corner_of_[v[2]]};
  }

 private:
  std::span<const std::uint32_t> indices_;
  const std::uint32_t* corner_of_ = nullptr;
  std::optional<std::size_t> uncut_;
};

class SurfaceHull {
 public:
  /// Steps of the grid: an edge that bends by less may be flat, because cuts are rounded to the seam lattice.
  static constexpr double kRounding = 8;
  /// No point may be above one of the kLargest largest triangles by more than kMostAbove times the rounding. That is 1e-4 of
  /// the body's box, a fraction of the hull's inset.
  static constexpr std::size_t kLargest = 16;
  static constexpr double kMostAbove = 8;

  enum class Shape {
    kOther,   ///< bends inwards, is flat, or is not a sphere
    kConvex,  ///< its hull is that of the points that stick out (list_sharp())
    kHull,    ///< the triangles are the hull: almost all points stick out, and the limit is kept
  };
  /// The corners are the grid's points. Each must belong to a triangle. `max_points`: maximum for a hull.
  Shape shape_of(const HullGrid& grid, const BodySurface& surface, std::uint32_t max_points, Pacer& pacer);
  /// Call after shape_of(). Lists all extreme points, and few others.
  void list_sharp(std::vector<std::uint32_t>& out) const;

  std::size_t bytes() const { return bytes_of_vectors(faces_, points_, corners_, after_, largest_, quads_); }
  void release() { release_vectors(faces_, points_, corners_, after_, largest_, quads_); }

 private:
  /// 4 f + k leads from corner k of face f to the next corner, stored at 4 f + k + 1 (the first corner is stored twice).
  using HalfEdge = std::uint32_t;
  struct Face {
    HullGrid::Plane plane;
    double rounding;            ///< kRounding steps, in the unit of HullGrid::height()
    std::uint32_t corners_sum;  ///< minus two of its corners: the third one
    bool bent;                  ///< bends inwards at an edge, by no more than rounding
  };
  struct Point {
    HalfEdge open;        ///< its first half-edge whose twin has not been found yet
    std::uint32_t edges;  ///< number of edges that bend outwards at all: an extreme point has at least three
    std::uint32_t creases;  ///< number of edges that bend outwards by more than rounding
    bool climbs;            ///< a neighbour is higher
  };

  /// Four points of the grid.
  struct Quad {
    using Four = float __attribute__((vector_size(16)));  // g++ and clang++, on any processor
    Four x, y, z;
  };

  bool bends_outwards(const HullGrid& grid, const BodySurface& surface, Pacer& pacer);
  void look_at_cuts(const HullGrid& grid, const BodySurface& surface, Pacer& pacer);
  void list_quads(const HullGrid& grid, Pacer& pacer);
  bool anything_above(const HullGrid& grid, const Face& face, double most, Pacer& pacer) const;
  bool nothing_above_the_largest(const HullGrid& grid, Pacer& pacer);
  bool nothing_above_the_bent(const HullGrid& grid, Pacer& pacer) const;
  bool add_edge(const HullGrid& grid, std::uint32_t a, std::uint32_t b, Face& left, Face& right);

  std::vector<Face> faces_;
  std::vector<Point> points_;
  std::vector<std::uint32_t> corners_;
  std::vector<HalfEdge> after_;  // the next half-edge of the same point
  std::vector<std::uint32_t> largest_;
  std::vector<Quad> quads_;
};

}  // namespace fracture
