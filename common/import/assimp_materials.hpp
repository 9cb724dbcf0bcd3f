// Converts the materials that Assimp read to glTF's (plain_materials.hpp).
#pragma once

#include <assimp/scene.h>

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/import.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

struct TranslatedMaterials {
  MaterialLibrary library;
  std::vector<std::uint32_t>
      slot;  ///< per Assimp material: index into the library, or kNoIndex for its placeholder
  Remarks remarks;
  std::vector<Dropped> dropped;
};

TranslatedMaterials translate_materials(const aiScene& scene, std::span<const ImportFile> files);

}  // namespace fracture
