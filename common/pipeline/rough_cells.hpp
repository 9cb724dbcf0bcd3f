// Fragments with rough cuts, and a fallback. If the result does not pass its proof (soundness.hpp), the
// cells concerned are cut again with less roughness, and then flat. The choice of these cells depends only
// on local geometry.
#pragma once

#include <functional>

#include "common/fragment/pieces.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/soundness.hpp"

namespace fracture {

/// How many times cells are restrained before all cuts are made flat.
inline constexpr int kMostRestraints = 3;

/// Roughens the caps of `restricted`, which are flat, and makes the fragments. Fills `rough` and `set` of
/// `cut`, among others. If the amplitude is 0, the caps stay flat. `limits`: of the pieces' sizes. `always`:
/// restraints from the start; empty: none. `before`: unions to make, whatever the size of the pieces. `judged`:
/// checks the fragments; see judge(). Unless the parameters have hits, pieces are first united by their size with
/// flat cuts, and then by their size with rough cuts. Throws Interrupted.
void make_rough_fragments(RestrictedDiagram& restricted, const FractureParameters& parameters,
                          SizeLimits limits, const Ownership& ownership, const Restraints& always,
                          std::vector<Union> before, const std::function<Verdict(const FragmentSet&)>& judged,
                          const Execution& execution, CutCells& cut);

}  // namespace fracture
