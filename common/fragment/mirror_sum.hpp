// Checks that every cap has its mirror image. Each cap is in two fragments, once as it is and once
// mirrored, with the same bits in world space (invariant I2). If so, a sum over all caps cancels.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Returns a sum over the fragment's cap triangles, from the positions in the file. A triangle and its
/// mirror image cancel, whichever corner each begins with, so the sums of all fragments add up to 0. If
/// mirror images are missing, they do so by chance with a probability of about 2^-58. Triangles with two
/// corners at one position contribute nothing, because they are their own mirror images. Throws
/// Interrupted.
std::uint64_t mirror_sum(const Fragment& fragment, const Execution& execution = kUninterrupted);

/// Returns the fragments that have a cap triangle without a mirror image, ascending. Sorts all triangles,
/// so it is only for results whose sums do not cancel. `count` receives the number of such triangles.
std::vector<std::uint32_t> unmirrored(const std::vector<Fragment>& fragments, std::uint64_t& count);

}  // namespace fracture
