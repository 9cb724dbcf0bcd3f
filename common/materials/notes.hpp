// Facts about materials that help people to choose one.
#pragma once

#include "common/materials/materials.hpp"

namespace fracture {

struct MaterialNotes {
  const char* use;        ///< things that are made of the material
  const char* mechanics;  ///< the literature on how the material breaks, which the preset follows
  /// Processor instructions for a mesh of 4,000 triangles with 50 sites, divided by those of `pattern=uniform` with flat cuts.
  double cost;
};

/// Every preset has notes.
const MaterialNotes& notes_of(const MaterialPreset& preset);

}  // namespace fracture
