// The fragments of an answer that a request asks for.
#pragma once

#include <optional>

#include "common/hits/delta.hpp"
#include "common/pipeline/refracture.hpp"

namespace fracture {

struct Selection {
  bool kept = false;                  ///< whether the answer is kept, because hits may follow
  std::optional<NewHits> new_hits{};  ///< if set, the answer is kept and compared with one without these hits
  std::optional<Refracture> refracture{};  ///< the parts of a single fragment; excludes the other two members
};

}  // namespace fracture
