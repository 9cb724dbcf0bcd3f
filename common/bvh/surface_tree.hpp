// The triangles of a surface in a tree of boxes. Finds the distance to a point, and the triangles near a box.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/bvh/box_tree.hpp"

namespace fracture {

/// The point of the triangle that is nearest to p (Ericson 2005, Real-Time Collision Detection, 5.1.5: the
/// regions of its corners, edges and face).
Vec3d nearest_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);
/// Distance from p to the triangle.
double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

class SurfaceTree {
 public:
  /// Takes triangles by their corners, m. Throws Interrupted.
  explicit SurfaceTree(std::vector<std::array<Vec3d, 3>> triangles, const Execution& execution = {});

  /// min(distance from p to the surface, most), m. Other triangles that are farther away do not change its
  /// bits, unless the nearest triangle is a needle hidden by rounding. Throws Interrupted.
  double distance(const Vec3d& p, double most, Pacer& pacer) const;
  /// Returns the distance between the triangle and the surface, m, or `most` if that is less. Throws
  /// Interrupted.
  double distance_of(const std::array<Vec3d, 3>& triangle, double most, Pacer& pacer) const;
  /// Whether the surface is nearer to p than this, m. Stops at the first such triangle.
  bool within(const Vec3d& p, double distance, Pacer& pacer) const;
  /// Whether the surface is nearer than this, m, to any point of the triangle; true if rounding makes it
  /// uncertain. Returns nothing if more than kMostAsked triangles of the surface may be that near.
  std::optional<bool> near_triangle(const std::array<Vec3d, 3>& triangle, double distance,
                                    Pacer& pacer) const;
  static constexpr std::size_t kMostAsked = 32;
  /// min(distance from p to the surface, most) for many points; faster if neighbouring points are
  /// consecutive.
  void distances(std::span<const Vec3d> points, double most, std::span<double> out, Pacer& pacer) const;
  /// Calls visit(triangle) for every triangle whose box overlaps.
  template <class Visit>
  void each_near(const Box& box, const Visit& visit) const {
    tree_.each_overlapping(box, visit);
  }
  std::size_t triangles() const { return corners_.size(); }
  const std::array<Vec3d, 3>& corners(std::uint32_t triangle) const { return corners_[triangle]; }
  const std::vector<std::array<Vec3d, 3>>& corners() const { return corners_; }

 private:
  /// The distance to this triangle if it is less than `most`, otherwise `most`.
  double nearer(const Vec3d& p, std::uint32_t triangle, double most, Pacer& pacer) const;

  template <class Reach, class Visit>
  void each_within(const std::array<Vec3d, 3>& triangle, const Reach& reach, Pacer& pacer,
                   const Visit& visit) const;

  std::vector<std::array<Vec3d, 3>> corners_;
  BoxTree tree_;
  double slack_ = 0;  // m; exceeds the rounding error of a distance, so all candidates are tested
};

}  // namespace fracture
