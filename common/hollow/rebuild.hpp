// A solid whose parts have cavities, as one list of triangles again.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/execution.hpp"
#include "common/hollow/cavity.hpp"
#include "common/solid/solid.hpp"

namespace fracture::hollow_detail {

/// The triangles of a part: they follow one another.
struct Run {
  std::size_t begin = 0, end = 0;
};

/// One for each part.
std::vector<Run> runs_of_parts(const Solid& solid);

/// Writes the parts anew, each with its cavity behind its own triangles. The cavities are in the order of their parts. Throws
/// Interrupted.
void rebuild(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution);

}  // namespace fracture::hollow_detail
