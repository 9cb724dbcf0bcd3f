// Fragments with rough cuts, and the net under them: where the answer does not prove itself (soundness.hpp),
// the cells concerned are cut again with less roughness, then flat. Which cells those are is a function of
// what is there, so that a hit elsewhere does not change it.
#pragma once

#include <functional>

#include "common/fragment/pieces.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/soundness.hpp"

namespace fracture {

/// How often cells are restrained before all cuts are made flat.
inline constexpr int kMostRestraints = 3;

/// Roughens the caps of `restricted`, which are flat, and makes the fragments. Fills `rough` and `set` of
/// `cut`. With an amplitude of 0 the caps stay flat. `limits`: limits_in_force(). `judged` says what holds of the
/// fragments: judge(). `trace`: roughen(). `before`: what is united whatever its size. Where there are no hits, pieces
/// are united by their size with flat cuts, too, and these are the `unions` of `cut`; then by that with rough ones: the
/// `late` ones. Throws Interrupted.
void make_rough_fragments(RestrictedDiagram& restricted, const FractureParameters& parameters,
                          SizeLimits limits, const Ownership& ownership, std::vector<Union> before,
                          const std::function<Verdict(const FragmentSet&)>& judged,
                          const Execution& execution, CutCells& cut,
                          std::optional<RoughTrace>* trace = nullptr);

}  // namespace fracture
