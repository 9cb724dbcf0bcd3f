// What people want to know of a material before they choose it.
#pragma once

#include "common/materials/materials.hpp"

namespace fracture {

struct MaterialNotes {
  const char* use;        ///< things that are made of it
  const char* mechanics;  ///< whose description of how it breaks the preset follows
  /// Instructions of fracturing a mesh of thousand triangles with 50 sites, divided by those of flat uniform cuts.
  double cost;
};

/// Every preset has some.
const MaterialNotes& notes_of(const MaterialPreset& preset);

}  // namespace fracture
