// What this service says in `extras.fracture`, which every tool keeps: figures of the whole on the root,
// figures of a fragment on its node. Keyed by fragment id, never by node index: tools reorder nodes.
#pragma once

#include <nlohmann/json.hpp>

#include "common/fragment/fragments.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// {version, algorithm, mesh, parameters, report, certificate, lattice, bonds {a, b, area, centroid, normal,
/// strength (N)}}
void write_root_extras(JsonText& json, const FragmentSet& fragments, const GltfOptions& options);

/// {id, volume, mass, area, exterior_area, center_of_mass, level, parent, anchored, part, sites}
void write_fragment_extras(JsonText& json, const Fragment& fragment, const GltfOptions& options);

}  // namespace fracture
