// Applies selectors to the parts of a solid.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/mesh/part_selector.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The parts that each of several selectors decides.
struct PartChoice {
  std::vector<std::uint32_t> of_part;  ///< per part: the first selector that matches it, or kNoIndex
  /// Per selector: whether it matches a part, even if an earlier one decides that part
  std::vector<bool> matches;
};

/// Finds the first selector that matches each part. Near-linear in parts and triangles for each selector. Throws Interrupted,
/// also if the patterns need more than kMostNameSteps (kTooComplex).
PartChoice choose_parts(const Solid& solid, const std::vector<PartSelector>& selectors,
                        const Execution& execution);

/// Returns one sentence for each selector that decides no part. It names the nearest names that exist.
std::vector<std::string> warnings_of(const Solid& solid, const std::vector<PartSelector>& selectors,
                                     const PartChoice& choice);

/// Returns a selector in words: "node 'Wall_*'", "slot 'Glass' and part 3".
std::string in_words(const PartSelector& selector);

}  // namespace fracture
