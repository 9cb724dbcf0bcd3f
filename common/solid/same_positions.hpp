// Finds equal positions among millions. This is the first half of welding, and the half that runs on several
// threads.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"

namespace fracture::solid_detail {

/// Replaces -0 by +0, because -0 + 0 is +0.
inline Vec3f with_one_zero(const Vec3f& p) { return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; }

/// Returns, for each position, the lowest index with the same position. Compares bits after with_one_zero(),
/// so a NaN equals itself. The cost is linear for any distribution of positions.
std::unique_ptr<std::uint32_t[]> first_of_same(const std::vector<Vec3f>& positions,
                                               const Execution& execution);

}  // namespace fracture::solid_detail
