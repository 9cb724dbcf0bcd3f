// How far a point is from the nearest of many triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture::hollow_detail {

using Corners = std::array<Vec3d, 3>;

/// From the point to the nearest point of the triangle, squared. Ericson 2005, "Real-Time Collision Detection",
/// 5.1.5: by the region of the triangle's plane that the point is above.
double squared_distance(const Vec3d& point, const Corners& triangle);

/// A bounding volume hierarchy of boxes, halved at the median along the direction in which the middles spread most.
/// Queries may run in several threads.
class TriangleTree {
 public:
  /// Throws Interrupted.
  explicit TriangleTree(std::vector<Corners> triangles, const Execution& execution = kUninterrupted);

  /// Whether a triangle is nearer to the point than that.
  bool within(const Vec3d& point, double distance) const;
  double distance(const Vec3d& point) const;

  double area() const { return area_; }

  /// How often the triangles enclose the point: all are looked at. Van Oosterom & Strackee 1983, "The Solid Angle of
  /// a Plane Triangle". Near a whole number for a closed surface that is not near.
  double winding(const Vec3d& point, Pacer& pacer) const;

 private:
  static constexpr std::uint32_t kLeaf = 4;
  struct Node {
    Box box;
    std::uint32_t begin, end;
    std::uint32_t right;  ///< the left child is the next node; 0: a leaf
  };
  void build(std::uint32_t begin, std::uint32_t end, Pacer& pacer);
  /// The least squared distance below `bound`, or `bound`.
  double nearest(const Vec3d& point, double bound, bool any) const;

  std::vector<Corners> triangles_;
  std::vector<Node> nodes_;
  double area_ = 0;
};

}  // namespace fracture::hollow_detail
