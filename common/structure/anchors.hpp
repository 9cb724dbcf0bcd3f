// What holds a fractured object: fragments that touch the ground, a wall, a bolt. The support
// analysis (support.hpp) starts from them.
#pragma once

#include <cstddef>
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

/// Which fragments are held. A companion of a FragmentSet.
struct AnchoredFragments {
  std::vector<char> held;   ///< per fragment; empty: none is
  std::uint32_t count = 0;  ///< how many are
  bool contains(std::size_t fragment) const { return !held.empty() && held[fragment] != 0; }
};

/// Judged on the final positions, each fragment by itself: the fragments of a delta are held as they are in the whole.
/// `longest_side`: of the solid, metres. Linear in planes x vertices; boxes and points are looked up in trees. Throws
/// Interrupted.
AnchoredFragments find_anchored(const FragmentSet& set, const Anchors& anchors, double longest_side,
                                const Execution& execution = {});

}  // namespace fracture
