// Checks every answer, using the float arrays that the file will contain. An answer that fails becomes an error
// (kUnsound) and is never returned.
//
//   I1  every fragment is closed, by topology and when welded       open_edges() of each fragment
//   I2  every cap triangle has one mirror image in world bits       mirror_sum() of all fragments cancels
//       volumes before rounding add up                              to 1e-9 of the shells' absolute volumes
//       volumes in the file add up                                  to (h + 2^-24 size) x exterior area
//       no fragment has a negative volume                           beyond that bound for its own area
//   I3  the solid's surface is covered once                         areas add up to (h + 2^-24 size) x edges
//       bodies that may collide do not overlap at spawn             by more than the tolerance of physics/rest.hpp
//
// Caps whose loops cross are counted (Certificate::crossing_caps) but not judged, because invariant I5 allows them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/rest.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The guarantees of an answer.
enum class Promise {
  kPartition,  ///< all of the above
  kClosed,     ///< only closed fragments, because barycentric cells overlap and leave gaps
};

struct Verdict {
  /// Sentences, with numbers and their bounds. Empty if the answer is sound.
  std::vector<std::string> violations;
  /// Indices of the affected fragments, ascending, if a violation is about certain fragments.
  std::vector<std::uint32_t> fragments;
  bool sound() const { return violations.empty(); }
};

/// Checks the certificate. If the answer is not sound, also finds the affected fragments. The set must be made from the
/// solid. If it is only a delta, its certificate is that of all fragments, and the others were judged before.
Verdict judge(const FragmentSet& set, const Solid& solid, Promise promise);

/// Checks that bodies rest. Without filters, overlaps are reported, but they are not violations.
Verdict judge_rest(const Rest& rest, HullFilters filters);

/// Returns kUnsound with the violations as its detail, and the certificate's numbers in `extra`.
Error unsound(const Verdict& verdict, const Certificate& certificate);

}  // namespace fracture
