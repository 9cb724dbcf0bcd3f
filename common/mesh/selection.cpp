#include "common/mesh/selection.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "common/base/gathered.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

constexpr std::size_t kListedNames = 50;  // maximum number in an error message

/// Marks the names that are selected; all of them if the list is empty.
Expected<std::vector<bool>> chosen(const std::vector<std::string>& entries,
                                   const std::vector<std::string>& names, const char* parameter) {
  std::vector<bool> result(names.size(), entries.empty());
  for (const std::string& entry : entries) {
    bool found = false;
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k] == entry) result[k] = found = true;
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(entry.data(), entry.data() + entry.size(), index);
    if (!found && error == std::errc{} && end == entry.data() + entry.size() && index < names.size())
      result[index] = found = true;
    if (found) continue;
    nlohmann::json known = nlohmann::json::array();
    for (std::size_t k = 0; k < std::min(names.size(), kListedNames); ++k) known.push_back(names[k]);
    return fail(ErrorCode::kBadParameter,
                "'" + entry.substr(0, 80) + "' is neither a name in '" + std::string(parameter) +
                    "' of this mesh nor an index below " + std::to_string(names.size()) +
                    ". The member 'known' lists the names.",
                parameter, {{"known", std::move(known)}});
  }
  return result;
}

std::vector<std::string> material_names(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const auto& material : mesh.library->materials) {
    const auto name = material.find("name");
    names.push_back(name != material.end() && name->is_string() ? name->get<std::string>() : std::string());
  }
  return names;
}

/// Returns the triangles with the given selection state, and the wedges that they use in the order of the
/// source. Data that is not per wedge or per triangle is shared.
Mesh part_of(const Mesh& mesh, const std::vector<bool>& selected, bool wanted) {
  constexpr std::uint32_t kUsed = 0;
  std::vector<std::uint32_t> new_wedge(mesh.positions.size(), kNoIndex), triangles, wedges;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (selected[t] != wanted) continue;
    triangles.push_back(t);
    for (const std::uint32_t w : mesh.triangles[t]) new_wedge[w] = kUsed;
  }
  for (std::uint32_t w = 0; w < new_wedge.size(); ++w) {
    if (new_wedge[w] == kNoIndex) continue;
    new_wedge[w] = static_cast<std::uint32_t>(wedges.size());
    wedges.push_back(w);
  }
  Mesh part;
  part.frame = mesh.frame;
  part.positions = gathered(mesh.positions, wedges);
  part.attributes.normals = gathered(mesh.attributes.normals, wedges);
  part.attributes.tangents = gathered(mesh.attributes.tangents, wedges);
  for (const auto& set : mesh.attributes.uvs) part.attributes.uvs.push_back(gathered(set, wedges));
  for (const auto& set : mesh.attributes.colors) part.attributes.colors.push_back(gathered(set, wedges));
  part.triangles = gathered(mesh.triangles, triangles);
  for (auto& triangle : part.triangles)
    for (std::uint32_t& w : triangle) w = new_wedge[w];
  part.material = gathered(mesh.material, triangles);
  part.node = gathered(mesh.node, triangles);
  part.node_names = mesh.node_names;
  part.instances = mesh.instances;
  part.triangle_color = gathered(mesh.triangle_color, triangles);
  part.library = mesh.library;
  part.copyright = mesh.copyright;
  return part;
}

}  // namespace

Expected<void> restrict_to(Mesh& mesh, const PartSelection& selection) {
  if (selection == PartSelection{}) return {};
  const Expected<std::vector<bool>> nodes = chosen(selection.nodes, mesh.node_names, "nodes");
  if (!nodes) return tl::unexpected<Error>(nodes.error());
  const Expected<std::vector<bool>> materials =
      chosen(selection.materials, material_names(mesh), "materials");
  if (!materials) return tl::unexpected<Error>(materials.error());

  std::vector<bool> selected(mesh.triangles.size());
  std::size_t count = 0;
  for (std::size_t t = 0; t < selected.size(); ++t) {
    const std::uint32_t node = mesh.node[t], material = mesh.material[t];
    const bool by_node = selection.nodes.empty() || (node < nodes->size() && (*nodes)[node]);
    const bool by_material =
        selection.materials.empty() || (material < materials->size() && (*materials)[material]);
    selected[t] = by_node && by_material;
    count += selected[t];
  }
  if (count == 0)
    return fail(ErrorCode::kBadParameter,
                "No triangle of this mesh is in the given nodes and materials: choose others.",
                selection.nodes.empty() ? "materials" : "nodes");
  if (count == selected.size()) return {};
  auto rest = std::make_shared<const Mesh>(part_of(mesh, selected, false));
  Mesh kept = part_of(mesh, selected, true);
  kept.remarks = std::move(mesh.remarks);
  kept.passed_through = std::move(rest);
  mesh = std::move(kept);
  return {};
}

}  // namespace fracture
