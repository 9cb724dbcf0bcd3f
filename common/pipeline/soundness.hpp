// Does an answer prove itself? Judged on every answer, from the float arrays that the file will hold; one
// that does not hold is an error (kUnsound), never an answer.
//
//   I1  every fragment is closed, in its topology and welded        open_edges() of each fragment
//   I2  every cap triangle has one mirror image in world bits       mirror_sum() of all fragments cancels
//       volumes before rounding add up                              to 1e-9 of the shells' absolute volumes
//       volumes in the file add up                                  to (h + 2^-24 size) x exterior area
//       no fragment has a negative volume                           beyond that bound for its own area
//   I3  the solid's surface is covered once                         areas add up to (h + 2^-24 size) x edges
//       bodies that may collide do not overlap at spawn             but by the tolerance of physics/rest.hpp
//
// Caps whose loops cross are counted (Certificate::crossing_caps), not judged: invariant I5 allows them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/rest.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// What is promised of an answer.
enum class Promise {
  kPartition,  ///< all of the above
  kClosed,     ///< closed fragments alone: barycentric cells overlap and leave gaps
};

struct Verdict {
  /// Sentences, each with the figure and its bound; empty: the answer is sound.
  std::vector<std::string> violations;
  /// The fragments concerned, ascending, where a violation is one of certain fragments.
  std::vector<std::uint32_t> fragments;
  bool sound() const { return violations.empty(); }
};

/// Looks at the certificate, and where the answer is not sound for the fragments concerned. The set must be of the
/// solid; of a delta alone the certificate is that of the whole, and the other fragments were judged before.
Verdict judge(const FragmentSet& set, const Solid& solid, Promise promise);

/// Without filters overlaps are stated, and no violation.
Verdict judge_rest(const Rest& rest, HullFilters filters);

/// kUnsound with the violations as the detail, and the certificate's figures in `extra`.
Error unsound(const Verdict& verdict, const Certificate& certificate);

}  // namespace fracture
