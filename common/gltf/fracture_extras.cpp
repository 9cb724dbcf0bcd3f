#include "common/gltf/fracture_extras.hpp"

namespace fracture {
namespace {

/// Raised when a key changes its meaning or goes away; new keys do not change it.
constexpr int kExtrasVersion = 1;

void write_certificate(JsonText& json, const Certificate& c) {
  json.begin_object()
      .member("open_edges", c.open_edges)
      .member("volume_in", c.volume_in)
      .member("volume_out", c.volume_out)
      .member("volume_file", c.volume_file)
      .member("relative_error", c.relative_error)
      .member("pocket_volume", c.pocket_volume)
      .member("pocket_area", c.pocket_area)
      .member("sites_asked", c.sites_asked)
      .member("cells", c.cells)
      .member("islands", c.islands)
      .member("united", c.united)
      .member("dropped", c.dropped)
      .member("fragments", c.fragments)
      .member("crossing_caps", c.crossing_caps)
      .end_object();
}

void write_bonds(JsonText& json, const FragmentSet& set, const GltfOptions& options) {
  const auto column = [&](const char* name, auto&& of) {
    json.key(name).begin_array();
    for (const Bond& bond : set.bonds) json.value(of(bond));
    json.end_array();
  };
  const auto id = [&](std::uint32_t index) { return set.fragments.at(index).id; };
  json.begin_object();
  column("a", [&](const Bond& bond) { return id(bond.a); });
  column("b", [&](const Bond& bond) { return id(bond.b); });
  column("area", [](const Bond& bond) { return bond.area; });
  column("centroid", [](const Bond& bond) { return bond.centroid; });
  column("normal", [](const Bond& bond) { return bond.normal; });
  column("strength", [&](const Bond& bond) { return bond.area * options.bond_strength; });
  json.end_object();
}

}  // namespace

void write_root_extras(JsonText& json, const FragmentSet& set, const GltfOptions& options) {
  json.begin_object()
      .member("version", kExtrasVersion)
      .member("algorithm", options.algorithm)
      .member("mesh", options.mesh_digest)
      .member("parameters", options.parameters)
      .member("report", set.report);
  json.key("lattice")
      .begin_object()
      .member("step", set.lattice_step)
      .member("ratio", set.lattice_ratio)
      .end_object();
  json.key("certificate");
  write_certificate(json, set.certificate);
  json.key("bonds");
  write_bonds(json, set, options);
  json.end_object();
}

void write_fragment_extras(JsonText& json, const Fragment& fragment, const GltfOptions& options) {
  const MassProperties& mass = fragment.mass;
  json.begin_object()
      .member("id", fragment.id)
      .member("volume", mass.volume)
      .member("mass", mass.volume * options.density)
      .member("area", mass.area)
      .member("exterior_area", fragment.exterior_area)
      .member("center_of_mass", mass.center_of_mass)
      .member("level", 0);
  json.key("parent").null();
  json.member("anchored", false).member("part", fragment.part);
  json.key("sites").begin_array();
  for (const std::uint32_t site : fragment.sites) json.value(site);
  json.end_array().end_object();
}

nlohmann::json fracture_extras(const FragmentSet& fragments, const GltfOptions& options) {
  JsonText json;
  write_root_extras(json, fragments, options);
  return nlohmann::json::parse(json.text());
}

}  // namespace fracture
