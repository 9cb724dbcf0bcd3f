// The report on a mesh, as JSON. It is the reply to a stored mesh, and the output of `fracture-server inspect`.
#pragma once

#include <nlohmann/json.hpp>

#include "server/service/service.hpp"

namespace fracture {

/// Returns whether the solid needed any repair beyond merging equal positions.
bool repaired(const SolidReport& report);

/// Returns an object with verdict ("closed" or "repaired"), solid, volume_once (pipeline/overlaps.hpp), frame, nodes,
/// materials, images, warnings, notes, choices, dropped (if anything is), passed_through and, if the mesh has several parts, contacts
/// (gltf/report_text.hpp).
nlohmann::json mesh_report(const PreparedMesh& mesh);

}  // namespace fracture
