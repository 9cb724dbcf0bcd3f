// The pieces of all sets of parts (part_sets.hpp) as one set of fragments.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/pipeline/fracture_steps.hpp"

namespace fracture {

class SetPieces {
 public:
  explicit SetPieces(const Execution& execution) : pacer_(execution) {}

  /// Adds the pieces of one set. `parts`: per part of the set, its number in the whole. `first_site`: the number of sites of
  /// the sets before. Changes the ids of fragments that an earlier set has too. Throws Interrupted.
  void add_set(CutCells cut, const std::vector<std::uint32_t>& parts, std::uint32_t first_site);

  /// Returns the pieces of all sets, with the lattice and the sums of `solid`, the whole.
  CutCells finish(const Solid& solid);

 private:
  Pacer pacer_;
  CutCells all_;
  std::unordered_set<std::uint64_t> ids_;  // only queried
};

}  // namespace fracture
