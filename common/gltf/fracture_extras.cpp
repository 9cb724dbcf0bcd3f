#include "common/gltf/fracture_extras.hpp"

#include "common/gltf/report_text.hpp"
#include "common/gltf/scene_layout.hpp"
#include "common/mesh/material_library.hpp"
#include "common/physics/principal_axes.hpp"

namespace fracture {
namespace {

/// Incremented when a key changes its meaning or is removed. New keys do not change it.
constexpr int kExtrasVersion = 1;

/// `id(index)`: returns the id of a bond's fragment or cluster.
template <class Id>
void write_bonds(JsonText& json, const std::vector<Bond>& bonds, const GltfOptions& options, const Id& id) {
  const auto column = [&](const char* name, auto&& of) {
    json.key(name).begin_array();
    for (const Bond& bond : bonds) json.value(of(bond));
    json.end_array();
  };
  const auto rounded_column = [&](const char* name, auto&& of) {
    json.key(name).begin_array();
    for (const Bond& bond : bonds) json.rounded(of(bond));
    json.end_array();
  };
  json.begin_object();
  column("a", [&](const Bond& bond) { return id(bond.a); });
  column("b", [&](const Bond& bond) { return id(bond.b); });
  rounded_column("area", [](const Bond& bond) { return bond.area; });
  rounded_column("centroid", [](const Bond& bond) { return bond.centroid; });
  rounded_column("normal", [](const Bond& bond) { return bond.normal; });
  rounded_column("strength",
                 [&](const Bond& bond) { return bond.area * options.bond_strength * bond.strength; });
  json.end_object();
}

/// Writes the bonds with nodes that are not fractured; nothing if there are none.
void write_whole_bonds(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options) {
  const std::vector<WholeBond>& bonds = fractured.whole_bonds;
  if (bonds.empty()) return;
  const auto column = [&](const char* name, auto&& write) {
    json.key(name).begin_array();
    for (const WholeBond& bond : bonds) write(bond);
    json.end_array();
  };
  json.key("whole_bonds").begin_object();
  column("a", [&](const WholeBond& bond) { json.value(fractured.set.fragments[bond.fragment].id); });
  column("node", [&](const WholeBond& bond) { json.value(bond.node); });
  column("area", [&](const WholeBond& bond) { json.rounded(bond.area); });
  column("centroid", [&](const WholeBond& bond) { json.rounded(bond.centroid); });
  column("normal", [&](const WholeBond& bond) { json.rounded(bond.normal); });
  column("strength",
         [&](const WholeBond& bond) { json.rounded(bond.area * options.bond_strength * bond.strength); });
  json.end_object();
}

/// Writes the id of the cluster to which a fragment, or a cluster of `level`, belongs. Null on the coarsest level.
void write_parent(JsonText& json, const Hierarchy& hierarchy, std::size_t level, std::uint32_t parent) {
  json.key("parent");
  if (level == 0)
    json.null();
  else
    json.value(hierarchy.levels[level - 1].clusters.at(parent).id);
}

/// Writes the levels above the fragments, coarsest first.
void write_levels(JsonText& json, const Hierarchy& hierarchy, const GltfOptions& options) {
  json.key("levels").begin_array();
  for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
    const ClusterLevel& here = hierarchy.levels[level];
    const auto column = [&](const char* name, auto&& of) {
      json.key(name).begin_array();
      for (const Cluster& cluster : here.clusters) json.value(of(cluster));
      json.end_array();
    };
    json.begin_object().member("level", level);
    column("id", [](const Cluster& c) { return c.id; });
    if (level > 0)
      column("parent",
             [&](const Cluster& c) { return hierarchy.levels[level - 1].clusters.at(c.parent).id; });
    column("fragments", [](const Cluster& c) { return c.fragments; });
    column("volume", [](const Cluster& c) { return c.volume; });
    column("mass", [&](const Cluster& c) { return c.volume * options.density * c.density_share; });
    column("center_of_mass", [](const Cluster& c) { return c.center_of_mass; });
    json.key("bonds");
    write_bonds(json, here.bonds, options, [&](std::uint32_t index) { return here.clusters.at(index).id; });
    json.end_object();
  }
  json.end_array();
}

/// Writes the parts whose pieces the fragment contains, if there are several.
void write_parts(JsonText& json, const Fragment& fragment) {
  if (fragment.part_cells.empty()) return;
  json.key("parts").begin_array();
  for (std::size_t k = 0; k < fragment.part_cells.size(); ++k)
    if (k == 0 || fragment.part_cells[k].part != fragment.part_cells[k - 1].part)
      json.value(fragment.part_cells[k].part);
  json.end_array();
}

}  // namespace

void write_root_extras(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options) {
  const FragmentSet& set = fractured.set;
  const std::optional<Delta>& delta = fractured.delta;
  json.begin_object()
      .member("version", kExtrasVersion)
      .member("algorithm", options.algorithm)
      .member("mesh", options.mesh_digest)
      .member("parameters", options.parameters);
  json.key("report");
  write_report(json, fractured);
  json.key("lattice")
      .begin_object()
      .member("step", set.lattice_step)
      .member("ratio", set.lattice_ratio)
      .end_object();
  json.key("interior_materials").begin_array();
  for (std::size_t k = 0; k < options.interior.materials.size(); ++k)
    json.value(set.source->library->materials.size() + k);
  json.end_array();
  json.key("certificate");
  write_certificate(json, set.certificate, fractured.rest);
  json.key("bonds");
  write_bonds(json, set.bonds, options, [&](std::uint32_t index) {
    return index < set.fragments.size() ? set.fragments[index].id
                                        : delta.value().neighbors.at(index - set.fragments.size());
  });
  write_whole_bonds(json, fractured, options);
  if (fractured.rest && !fractured.rest->filtered.empty()) {
    const auto column = [&](const char* name, std::size_t which) {
      json.key(name).begin_array();
      for (const auto& pair : fractured.rest->filtered) json.value(pair[which]);
      json.end_array();
    };
    json.key("filtered").begin_object();
    column("a", 0);
    column("b", 1);
    json.end_object();
  }
  if (delta) {
    const auto ids = [&](const char* name, const std::vector<std::uint64_t>& list) {
      json.key(name).begin_array();
      for (const std::uint64_t id : list) json.value(id);
      json.end_array();
    };
    json.key("delta").begin_object();
    ids("new", delta->added);
    ids("changed", delta->changed);
    ids("gone", delta->gone);
    json.end_object();
  }
  if (!fractured.hierarchy.levels.empty()) write_levels(json, fractured.hierarchy, options);
  json.end_object();
}

void write_fragment_extras(JsonText& json, const FracturedSolid& fractured, std::size_t index,
                           const GltfOptions& options, const SourceOfFragments& sources) {
  const Fragment& fragment = fractured.set.fragments[index];
  const Hierarchy& hierarchy = fractured.hierarchy;
  const MassProperties& mass = fragment.mass;
  const double volume = body_volume(fragment);
  const std::size_t level = hierarchy.levels.size();
  json.begin_object()
      .member("id", fragment.id)
      .member("volume", volume)
      .member("mass", volume * options.density * fragment.density_share)
      .member("area", mass.area)
      .member("exterior_area", fragment.exterior_area)
      .member("center_of_mass", mass.center_of_mass)
      .member("level", level);
  write_parent(json, hierarchy, level, level > 0 ? hierarchy.cluster_of_fragment[index] : kNoIndex);
  json.member("anchored", fractured.anchored.contains(index)).member("part", fragment.part);
  write_parts(json, fragment);
  json.key("sites").begin_array();
  const std::vector<std::uint32_t>& point_of = fractured.point_of_site;
  for (const std::uint32_t site : fragment.sites) json.value(point_of.empty() ? site : point_of.at(site));
  json.end_array();
  if (const InstancedBodies::Body* const body = instance_in_file(fractured, options, index))
    json.member("shape", fractured.instances.numbers[body->shape]);
  if (level > 0) sources.write(json, sources.of(index));  // otherwise, a group node says it
  json.end_object();
}

void write_source_extras(JsonText& json, const Mesh& source, std::uint32_t node) {
  if (node < source.node_extras.size() && !source.node_extras[node].empty())
    json.value_text(source.node_extras[node]);
}

void write_cluster_extras(JsonText& json, const Hierarchy& hierarchy, std::size_t level, std::size_t cluster,
                          const GltfOptions& options) {
  const Cluster& c = hierarchy.levels[level].clusters[cluster];
  json.begin_object().member("cluster", c.id).member("level", level);
  write_parent(json, hierarchy, level, c.parent);
  json.member("fragments", c.fragments)
      .member("volume", c.volume)
      .member("mass", c.volume * options.density * c.density_share)
      .member("center_of_mass", c.center_of_mass)
      .end_object();
}

nlohmann::json fracture_extras(const FracturedSolid& fractured, const GltfOptions& options) {
  JsonText json;
  write_root_extras(json, fractured, options);
  return nlohmann::json::parse(json.text());
}

}  // namespace fracture
