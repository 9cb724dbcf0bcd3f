// Converts a solid whose parts have cavities back to one list of triangles.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/execution.hpp"
#include "common/hollow/cavity.hpp"
#include "common/solid/solid.hpp"

namespace fracture::hollow_detail {

/// The triangles of a part, which are consecutive.
struct Run {
  std::size_t begin = 0, end = 0;
};

/// Returns one run per part.
std::vector<Run> runs_of_parts(const Solid& solid);

/// Rewrites the parts, each with its cavity after its own triangles. The cavities are in the order of their
/// parts. Throws Interrupted.
void rebuild(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution);

}  // namespace fracture::hollow_detail
