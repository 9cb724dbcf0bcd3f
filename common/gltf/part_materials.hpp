// Looks and surfaces of parts that are made of different materials.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/gltf/exterior_material.hpp"
#include "common/gltf/interior_material.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The materials of cuts if each part has the look `looks[look_of_part[part]]`. Looks that are equal share their materials. Names
/// are made unique. `uvs` and `detail` of the first look hold for all. Each look has at most kMostInteriorMaterials. Otherwise as
/// interior_materials() for a single look, with its errors. Throws Interrupted.
Expected<InteriorMaterials> interior_materials_of_parts(const std::vector<InteriorLook>& looks,
                                                        const std::vector<std::uint32_t>& look_of_part,
                                                        const Solid& solid, const Execution& execution,
                                                        std::uint32_t pieces);

/// The same for the outside.
ExteriorMaterials exterior_materials_of_parts(const std::vector<ExteriorLook>& looks,
                                              const std::vector<std::uint32_t>& look_of_part,
                                              const Solid& solid, const Execution& execution);

}  // namespace fracture
