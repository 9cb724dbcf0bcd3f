// What this service says in `extras.fracture`, which every tool keeps: figures of the whole on the root,
// figures of a fragment on its node. Keyed by fragment id, never by node index: tools reorder nodes.
#pragma once

#include <nlohmann/json.hpp>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/json_text.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// {version, algorithm, mesh, parameters, report, certificate, lattice, bonds {a, b, area, centroid, normal,
/// strength (N)}, filtered {a, b}, levels}: one entry for each level above the fragments, coarsest first, {level, id,
/// parent, fragments, volume, mass, center_of_mass, bonds}, its figures in columns; absent without a hierarchy; with
/// a delta `delta {new, changed, gone}`, ids. `filtered` has the ids of the two fragments of each pair that the collision
/// filters exclude, in a delta of pairs with a new or changed fragment; absent if there are none.
void write_root_extras(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options);

/// {id, volume, mass, area, exterior_area, center_of_mass, level, parent, anchored, part, sites}
void write_fragment_extras(JsonText& json, const FracturedSolid& fractured, std::size_t index,
                           const GltfOptions& options);

/// {cluster, level, parent, fragments, volume, mass, center_of_mass}. Its id is called `cluster`: only
/// fragments have an `id`.
void write_cluster_extras(JsonText& json, const Hierarchy& hierarchy, std::size_t level, std::size_t cluster,
                          const GltfOptions& options);

}  // namespace fracture
