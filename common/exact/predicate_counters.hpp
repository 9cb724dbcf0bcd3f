#pragma once

#include <cstdint>

namespace fracture::exact {

/// Counts how decisions were made. Pass one to a predicate to count its calls; nullptr costs only a test on
/// the slow path.
struct PredicateCounters {
  std::uint64_t exact = 0;  ///< the filter could not certify the sign
  std::uint64_t ties = 0;   ///< exact zero: coplanar (orient3d), or decided by the weights (in_sphere)
};

}  // namespace fracture::exact
