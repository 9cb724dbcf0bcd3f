#pragma once

#include <cstdint>

namespace fracture::exact {

/// How decisions were made: pass one to a predicate to have it counted; nullptr costs a test on the slow path
/// only.
struct PredicateCounters {
  std::uint64_t exact = 0;  ///< the filter could not certify the sign
  std::uint64_t ties = 0;   ///< exact zero: coplanar (orient3d), or decided by the weights (in_sphere)
};

}  // namespace fracture::exact
