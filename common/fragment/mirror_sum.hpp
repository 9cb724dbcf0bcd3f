// Has every cap its mirror image? Each cap stands in two fragments, once as it is and once mirrored, with the
// same bits in world space (invariant I2). A sum over all of them that cancels says so.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Sum over the cap triangles of the fragment, from the positions that the file holds: a triangle and its
/// mirror image cancel, whichever corner each begins with, so that the sums of all fragments add up to 0. By
/// chance they do so with a probability of about 2^-58. Triangles with two corners at one place count
/// nothing: they are their own mirror images. Throws Interrupted.
std::uint64_t mirror_sum(const Fragment& fragment, const Execution& execution = kUninterrupted);

/// Which fragments have a cap triangle without mirror image, ascending: sorts all triangles, for answers
/// whose sums do not cancel. `count`: how many such triangles there are.
std::vector<std::uint32_t> unmirrored(const std::vector<Fragment>& fragments, std::uint64_t& count);

}  // namespace fracture
