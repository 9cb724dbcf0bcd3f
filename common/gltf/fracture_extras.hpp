// The contents of `extras.fracture`, which every tool keeps: data about the whole result on the root node, and
// data about a fragment on its node. Fragments are named by id, never by node index, because tools reorder nodes.
#pragma once

#include <nlohmann/json.hpp>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/group_nodes.hpp"
#include "common/gltf/json_text.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// Writes {version, algorithm, mesh, parameters, report, lattice, interior_materials, certificate, bonds {a, b, area,
/// centroid, normal, strength (N)}, filtered {a, b}, delta {new, changed, gone}, levels}. `filtered`: pairs of ids that the
/// collision filters exclude (in a delta, only pairs with a new or changed fragment); absent if there are none. `delta`: ids;
/// only in a delta. `levels`: one entry for each level above the fragments, coarsest first: {level, id, parent, fragments,
/// volume, mass, center_of_mass, bonds}, in columns; absent without a hierarchy.
void write_root_extras(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options);

/// Writes {id, volume, mass, area, exterior_area, center_of_mass, level, parent, anchored, part, parts (if several), sites, shape
/// (of an instance), source (with levels)}.
void write_fragment_extras(JsonText& json, const FracturedSolid& fractured, std::size_t index,
                           const GltfOptions& options, const SourceOfFragments& sources);

/// Appends the members of the extras that the node has in the source (Mesh::node_extras) to an object.
void write_source_extras(JsonText& json, const Mesh& source, std::uint32_t node);

/// Writes {cluster, level, parent, fragments, volume, mass, center_of_mass}. The cluster's id is called `cluster`,
/// because only fragments have an `id`.
void write_cluster_extras(JsonText& json, const Hierarchy& hierarchy, std::size_t level, std::size_t cluster,
                          const GltfOptions& options);

}  // namespace fracture
