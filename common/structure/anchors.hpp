// What holds a fractured object: fragments that touch the ground, a wall, a bolt. They are marked, and the
// support analysis (support.hpp) starts from them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// All points x with normal · x <= offset (metres along the normal, which need not be of unit length: both
/// are divided by it).
struct HalfSpace {
  Vec3d normal{0, 1, 0};
  double offset = 0;
  Vec3d point{};  ///< one of the plane, as the caller gave it; not used
};

struct Anchors {
  std::vector<HalfSpace> planes;  ///< hold every fragment that reaches into one
  std::vector<Box> boxes;         ///< hold every fragment they overlap
  std::vector<Vec3d> points;      ///< hold every fragment they lie in or on
  bool any() const { return !planes.empty() || !boxes.empty() || !points.empty(); }
};

/// Touching counts: what comes within this fraction of the solid's longest side.
inline constexpr double kAnchorTolerance = 1e-5;

/// Sets Fragment::anchored of every fragment, judged on the final positions. Returns how many are held.
/// Linear in planes x vertices; boxes and points are looked up in trees. Throws Interrupted.
std::uint32_t mark_anchored(FragmentSet& set, const Anchors& anchors, const Execution& execution = {});

}  // namespace fracture
