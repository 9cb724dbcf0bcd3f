// What a mesh is worth, as JSON: the reply to a stored mesh, and `fracture-server inspect`.
#pragma once

#include <nlohmann/json.hpp>

#include "server/service/service.hpp"

namespace fracture {

/// Did the solid need anything beyond merging equal positions?
bool repaired(const SolidReport& report);

/// verdict ("closed" or "repaired"), solid, frame, nodes, materials, images, warnings, notes, passed_through and, if
/// the mesh has several parts, contacts (gltf/report_text.hpp).
nlohmann::json mesh_report(const PreparedMesh& mesh);

}  // namespace fracture
