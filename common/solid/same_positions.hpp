// Which of millions of positions are the same: the first half of welding, and the part of it that threads share.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"

namespace fracture::solid_detail {

/// With one zero: -0 + 0 is +0.
inline Vec3f with_one_zero(const Vec3f& p) { return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; }

/// Per position: the lowest index that has the same one. Bits are compared, after with_one_zero(); so a NaN is
/// like itself. The cost is linear, wherever they lie.
std::unique_ptr<std::uint32_t[]> first_of_same(const std::vector<Vec3f>& positions,
                                               const Execution& execution);

}  // namespace fracture::solid_detail
