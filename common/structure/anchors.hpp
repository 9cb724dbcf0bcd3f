// Anchors of a fractured object: fragments that touch the ground, a wall or a bolt are held. The support
// analysis (support.hpp) starts from them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// All points x with normal · x <= offset. The normal need not be of unit length: it is normalized, so the
/// offset is in metres.
struct HalfSpace {
  Vec3d normal{0, 1, 0};
  double offset = 0;
  Vec3d point{};  ///< a point of the plane, as given by the caller; not used
};

struct Anchors {
  std::vector<HalfSpace> planes;  ///< hold every fragment that reaches into one of them
  std::vector<Box> boxes;         ///< hold every fragment they overlap
  std::vector<Vec3d> points;      ///< hold every fragment they lie in or on
  bool any() const { return !planes.empty() || !boxes.empty() || !points.empty(); }
};

/// Tolerance for touching, as a fraction of the solid's longest side.
inline constexpr double kAnchorTolerance = 1e-5;

/// Held fragments. A companion of a FragmentSet.
struct AnchoredFragments {
  std::vector<char> held;   ///< per fragment; if empty, none is held
  std::uint32_t count = 0;  ///< number of held fragments
  bool contains(std::size_t fragment) const { return !held.empty() && held[fragment] != 0; }
};

/// Finds the held fragments from their final positions. Each fragment is tested by itself, so the fragments
/// of a delta are held as they are in the whole. `longest_side`: of the solid, metres. Linear in planes x
/// vertices; boxes and points are looked up in trees. Throws Interrupted.
AnchoredFragments find_anchored(const FragmentSet& set, const Anchors& anchors, double longest_side,
                                const Execution& execution = {});

}  // namespace fracture
