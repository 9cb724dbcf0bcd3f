// The region of a triangle that is inside the other part, as convex polygons.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/contacts/crossings.hpp"

namespace fracture::contacts_detail {

/// A convex region of the triangle. `winding`: the other part's winding number there, not 0.
struct ConvexRegion {
  static constexpr std::size_t kMost = 12;
  std::array<Vec3d, kMost> corners;  ///< m
  std::size_t size;
  double area;  ///< m²
  int winding;
};

/// Sweeps along a triangle's longest edge (trapezoidal decomposition: Preparata & Shamos 1985,
/// Computational Geometry, 2.2.2.4). It starts from the winding number at the edge's beginning and passes
/// over the segments in which the other part crosses the triangle. Adjacent trapezoids are joined if the
/// result is convex. Reuses its memory from triangle to triangle. Borrows the pacer.
class TrapezoidSweep {
 public:
  explicit TrapezoidSweep(Pacer& pacer) : pacer_(pacer) {}
  /// Returns all regions of one triangle, valid until the next call. `windings`: the other part's winding
  /// numbers at the corners. Takes the time to sort the segments and to examine the neighbouring segments
  /// at each segment's ends.
  const std::vector<ConvexRegion>& of(const NearTriangle& t, std::span<const Segment> segments,
                                      std::span<const EdgeJump> jumps, const std::array<int, 3>& windings);

 private:
  /// A segment in the plane of the triangle, u along the longest edge.
  struct Line {
    double u0, v0, u1, v1;  ///< u0 < u1
    int step;               ///< change of the winding number from below to above
    double at(double u) const { return v0 + (u - u0) / (u1 - u0) * (v1 - v0); }
  };
  /// The corners of a region on one side, from left to right, and the line that the region currently
  /// follows.
  struct Chain {
    std::uint32_t line;
    std::size_t size;
    std::array<double, ConvexRegion::kMost / 2> u, v;
  };
  /// A region that may continue.
  struct Open {
    Chain below, above;
    int winding;
  };
  static constexpr std::uint32_t kBottom = 0xfffffffdu, kLeftRoof = 0xfffffffeu, kRightRoof = 0xffffffffu;

  void set_frame(const NearTriangle& t);
  void add_lines(std::span<const Segment> segments);
  double height(std::uint32_t line, double u) const;
  double slope(std::uint32_t line) const;
  bool goes_on(Chain& chain, std::uint32_t line, double at, double outwards) const;
  void close(Open& open, double until);

  Pacer& pacer_;
  std::size_t edge_ = 0;
  Vec3d origin_, along_, up_;
  double length_ = 0, apex_u_ = 0, apex_v_ = 0;
  std::vector<Line> lines_;
  std::vector<double> stops_;
  std::vector<std::uint32_t> active_;
  std::vector<Open> open_, next_;
  std::vector<std::uint32_t> new_;  ///< regions in next_ that do not continue a region in open_
  std::vector<ConvexRegion> made_;
};

}  // namespace fracture::contacts_detail
