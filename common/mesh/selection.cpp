#include "common/mesh/selection.hpp"

#include <utility>

#include "common/base/gathered.hpp"
#include "common/base/nearest_name.hpp"
#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/part_selector.hpp"

namespace fracture {
namespace {

constexpr std::size_t kListedNames = 50;  // maximum number in an error message

/// The error for an entry that selects nothing. `count`: of the nodes or materials, `names`: each of their names once.
tl::unexpected<Error> no_such(const std::string& entry, const char* parameter, const char* one,
                              std::size_t count, const std::vector<std::string>& names) {
  std::string detail = std::string("'") + parameter + "': this mesh has no " + one + " named '" +
                       shortened(printable(entry)) + "', and no name matches it as a pattern.";
  if (count == 0) {
    detail += std::string(" It has no ") + parameter + ": leave '" + parameter + "' out.";
  } else if (names.size() == 1) {
    detail += " Its only name is '" + shortened(printable(names.front())) + "'.";
  } else {
    detail += printable(did_you_mean(entry, names)) + " Use a name from 'known' (nearest first)" +
              (count > 1 ? ", or an index from 0 to " + grouped(count - 1) + "." : ".");
  }
  return fail(ErrorCode::kBadParameter, std::move(detail), parameter,
              {{"known", nearest_names(entry, names, kListedNames)}});
}

/// Marks what the entries select; everything if there are none.
/// `mark(entry, marked)`: SceneNames::mark_nodes() or mark_slots().
template <class Mark>
Expected<std::vector<bool>> chosen(const std::vector<std::string>& entries, const SceneNames& scene,
                                   std::size_t count, const std::vector<std::string>& names,
                                   const char* parameter, const char* one, const Mark& mark) {
  std::vector<bool> result(count, entries.empty());
  for (const std::string& entry : entries) {
    if (mark(entry, result)) continue;
    if (scene.spent())
      return fail(ErrorCode::kBadParameter,
                  "The patterns in '" + std::string(parameter) + "' need more than " +
                      grouped(kMostNameSteps) +
                      " comparisons with the names of this mesh. Give simpler patterns.",
                  parameter);
    return no_such(entry, parameter, one, count, names);
  }
  return result;
}

/// Returns the triangles with the given selection state, and the wedges that they use in the order of the
/// source. Data that is not per wedge or per triangle is shared.
Mesh part_of(const Mesh& mesh, const std::vector<bool>& selected, bool wanted, Pacer& pacer) {
  constexpr std::uint32_t kUsed = 0;
  std::vector<std::uint32_t> new_wedge(mesh.positions.size(), kNoIndex), triangles, wedges;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    pacer.step();
    if (selected[t] != wanted) continue;
    triangles.push_back(t);
    for (const std::uint32_t w : mesh.triangles[t]) new_wedge[w] = kUsed;
  }
  for (std::uint32_t w = 0; w < new_wedge.size(); ++w) {
    pacer.step();
    if (new_wedge[w] == kNoIndex) continue;
    new_wedge[w] = static_cast<std::uint32_t>(wedges.size());
    wedges.push_back(w);
  }
  const auto taken = [&](const auto& values, const std::vector<std::uint32_t>& of) {
    return gathered(values, of, [&] { pacer.step(); });
  };
  Mesh part;
  part.frame = mesh.frame;
  part.positions = taken(mesh.positions, wedges);
  part.attributes.normals = taken(mesh.attributes.normals, wedges);
  part.attributes.tangents = taken(mesh.attributes.tangents, wedges);
  for (const auto& set : mesh.attributes.uvs) part.attributes.uvs.push_back(taken(set, wedges));
  for (const auto& set : mesh.attributes.colors) part.attributes.colors.push_back(taken(set, wedges));
  part.triangles = taken(mesh.triangles, triangles);
  for (auto& triangle : part.triangles) {
    pacer.step();
    for (std::uint32_t& w : triangle) w = new_wedge[w];
  }
  part.material = taken(mesh.material, triangles);
  part.node = taken(mesh.node, triangles);
  part.node_names = mesh.node_names;
  part.node_extras = mesh.node_extras;
  part.groups = mesh.groups;
  part.group_of_node = mesh.group_of_node;
  part.source_tree = mesh.source_tree;
  part.instances = mesh.instances;
  part.triangle_color = taken(mesh.triangle_color, triangles);
  part.library = mesh.library;
  part.copyright = mesh.copyright;
  return part;
}

}  // namespace

void keep_triangles(Mesh& mesh, const std::vector<bool>& kept, Pacer& pacer) {
  Mesh part = part_of(mesh, kept, true, pacer);
  mesh.positions = std::move(part.positions);
  mesh.attributes = std::move(part.attributes);
  mesh.triangles = std::move(part.triangles);
  mesh.material = std::move(part.material);
  mesh.node = std::move(part.node);
  mesh.triangle_color = std::move(part.triangle_color);
}

Expected<void> restrict_to(Mesh& mesh, const PartSelection& selection, const Execution& execution) {
  if (selection == PartSelection{}) return {};
  Pacer pacer(execution);
  SceneNames scene(mesh);
  const Expected<std::vector<bool>> nodes = chosen(
      selection.nodes, scene, scene.node_count(), scene.nodes(), "nodes", "node",
      [&](const std::string& entry, std::vector<bool>& marked) { return scene.mark_nodes(entry, marked); });
  if (!nodes) return tl::unexpected<Error>(nodes.error());
  const Expected<std::vector<bool>> materials = chosen(
      selection.materials, scene, scene.slot_count(), scene.slots(), "materials", "material",
      [&](const std::string& entry, std::vector<bool>& marked) { return scene.mark_slots(entry, marked); });
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
  auto rest = std::make_shared<const Mesh>(part_of(mesh, selected, false, pacer));
  Mesh kept = part_of(mesh, selected, true, pacer);
  kept.remarks = std::move(mesh.remarks);
  kept.dropped = std::move(mesh.dropped);
  kept.empty_nodes = std::move(mesh.empty_nodes);
  kept.passed_through = std::move(rest);
  mesh = std::move(kept);
  return {};
}

}  // namespace fracture
