// What leaves the pipeline: the fragments of a solid with their companions, each made by its own room from the
// set alone. File-format free: gltf/ writes it down, tests judge it.
#pragma once

#include <optional>

#include "common/fragment/fragments.hpp"
#include "common/pipeline/keep_changed.hpp"
#include "common/pipeline/report.hpp"
#include "common/structure/hierarchy.hpp"
#include "common/structure/support.hpp"

namespace fracture {

struct FracturedSolid {
  FragmentSet set;
  Hierarchy hierarchy;               ///< without levels unless asked for
  std::optional<Support> support{};  ///< where there are anchors, by who knows density and strength
  std::optional<Delta> delta{};      ///< where the answer is compared with an earlier one
  Report report;
};

}  // namespace fracture
