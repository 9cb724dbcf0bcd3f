// What leaves the pipeline: the fragments of a solid with their companions, each made by its own room from the
// set alone. File-format free: gltf/ writes it down, tests judge it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "common/fragment/fragments.hpp"
#include "common/pipeline/keep_changed.hpp"
#include "common/structure/hierarchy.hpp"

namespace fracture {

struct FracturedSolid {
  FragmentSet set;
  Hierarchy hierarchy;           ///< without levels unless asked for
  std::optional<Delta> delta{};  ///< where the answer is compared with an earlier one
  nlohmann::json report;         ///< the solid's report, the sites' report, warnings
};

}  // namespace fracture
