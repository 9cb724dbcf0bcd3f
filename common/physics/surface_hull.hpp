// The hull of a body that is convex but for rounding, as most fragments are: its own surface. A few tests for each
// edge replace the search for each point's place; what is not convex is recognized early.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/physics/hull_grid.hpp"

namespace fracture {

/// Triangles between the corners of a body, counter-clockwise from outside; borrowed. None: nothing is known of them.
class BodySurface {
 public:
  BodySurface() = default;
  /// `indices`: three vertices each; `corner_of`: of each vertex, which corner it stands at. `uncut`: where it is known
  /// that the surface is closed and that only its first triangles can bend inwards, among themselves, how many these are;
  /// the others are then cuts, faces of a convex cell.
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
  /// Steps of the grid: what an edge bends by less may be flat. Cuts are rounded to the seam lattice.
  static constexpr double kRounding = 8;
  /// So many of the largest triangles are asked whether anything lies above them, by more than so many times the
  /// rounding: 1e-4 of the body's box, a fraction of the hull's inset.
  static constexpr std::size_t kLargest = 16;
  static constexpr double kMostAbove = 8;

  enum class Shape {
    kOther,   ///< bends inwards, is no sphere, or flat
    kConvex,  ///< the hull of the points that stick out (sharp())
    kHull,    ///< the same, and almost all points do, no more than may: the triangles are the hull
  };
  /// The corners are the points of the grid, each of them that of some triangle; `max_points`: of a hull.
  Shape shape_of(const HullGrid& grid, const BodySurface& surface, std::uint32_t max_points, Pacer& pacer);
  /// After shape_of(): all extreme points, and few others.
  void list_sharp(std::vector<std::uint32_t>& out) const;

  std::size_t bytes() const { return bytes_of_vectors(faces_, points_, corners_, after_, largest_, quads_); }
  void release() { release_vectors(faces_, points_, corners_, after_, largest_, quads_); }

 private:
  /// 4 f + k leads from corner k of face f to the next one, which stands at 4 f + k + 1 (the first one twice).
  using HalfEdge = std::uint32_t;
  struct Face {
    HullGrid::Plane plane;
    double rounding;            ///< of twice its area times a height: kRounding steps
    std::uint32_t corners_sum;  ///< less two of them: the third
    bool bent;                  ///< inwards at one of its edges, by no more than rounding
  };
  struct Point {
    HalfEdge open;          ///< the first half-edge from it whose twin is not found yet
    std::uint32_t edges;    ///< that bend outwards at all: an extreme point has three at least
    std::uint32_t creases;  ///< that bend outwards by more than rounding
    bool climbs;            ///< some neighbour is higher
  };

  /// Four points of the grid.
  struct Quad {
    using Four = float __attribute__((vector_size(16)));  // g++ and clang++, of any processor
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
