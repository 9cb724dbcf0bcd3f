// Which fragments are wanted of the answer to some parameters.
#pragma once

#include <optional>

#include "common/hits/delta.hpp"
#include "common/pipeline/refracture.hpp"

namespace fracture {

struct Selection {
  bool kept = false;                  ///< hits may follow: what they start from is kept
  std::optional<NewHits> new_hits{};  ///< the answer is compared with the one without them; it is kept, too
  std::optional<Refracture> refracture{};  ///< the parts of one fragment; neither of the above
};

}  // namespace fracture
