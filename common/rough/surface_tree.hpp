// The outer surface of a solid: how far it is from a point, and which of its triangles are near a box.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rough/box_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Distance from p to the triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5: the regions of its
/// corners, edges and face).
double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

class SurfaceTree {
 public:
  /// Throws Interrupted.
  explicit SurfaceTree(const Solid& solid, const Execution& execution = {});

  /// min(distance from p to the surface, most), m. Throws Interrupted.
  double distance(const Vec3d& p, double most, Pacer& pacer) const;
  /// The same of many points; quicker where neighbours follow one another.
  void distances(std::span<const Vec3d> points, double most, std::span<double> out, Pacer& pacer) const;
  /// visit(triangle) for every one whose box overlaps.
  template <class Visit>
  void each_near(const Box& box, const Visit& visit) const {
    tree_.each_overlapping(box, visit);
  }
  std::size_t triangles() const { return corners_.size(); }
  const std::array<Vec3d, 3>& corners(std::uint32_t triangle) const { return corners_[triangle]; }

 private:
  std::vector<std::array<Vec3d, 3>> corners_;
  BoxTree tree_;
};

}  // namespace fracture
