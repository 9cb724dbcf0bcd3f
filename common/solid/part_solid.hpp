// Some parts of a solid as a solid of their own, for parts that are fractured with other parameters than the rest.
#pragma once

#include <cstdint>
#include <span>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns the parts with these numbers, in this order. Everything keeps its order, positions their bits. The result has the source
/// of the whole, its own box and volume, and the contacts among its parts. Its report has no counts of repairs and no
/// remarks. `parts`: ascending, without duplicates. n log n in the size of the result, and linear in the contacts of the whole.
/// Throws Interrupted.
Solid solid_of_parts(const Solid& whole, std::span<const std::uint32_t> parts, const Execution& execution);

}  // namespace fracture
