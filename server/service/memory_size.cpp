// Estimates how many bytes of heap the cached values use.
#include "common/base/heap_bytes.hpp"
#include "common/base/json_reader.hpp"
#include "common/contacts/scenery.hpp"
#include "common/hits/delta.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"
#include "server/service/service.hpp"

namespace fracture {
namespace {

std::size_t memory_size(const MaterialLibrary& library) {
  std::size_t bytes = sizeof library + heap(library.images) + heap(library.extensions_used) +
                      heap(library.extensions_required);
  for (const nlohmann::json* list : json_lists(library)) bytes += json_bytes(*list);
  for (const Image& image : library.images)
    bytes += heap(image.bytes) + image.name.capacity() + image.mime_type.capacity();
  return bytes;
}

}  // namespace

std::size_t memory_size(const Mesh& mesh) {
  std::size_t bytes =
      sizeof mesh + heap(mesh.positions) + heap(mesh.attributes.normals) + heap(mesh.attributes.tangents) +
      nested_heap(mesh.attributes.uvs) + nested_heap(mesh.attributes.colors) + heap(mesh.triangles) +
      heap(mesh.material) + heap(mesh.node) + heap(mesh.node_names) + heap(mesh.node_extras) +
      heap(mesh.empty_nodes) + heap(mesh.groups) + heap(mesh.group_of_node) + heap(mesh.instances) +
      heap(mesh.triangle_color) + heap(mesh.remarks.warnings) + heap(mesh.remarks.notes) +
      heap(mesh.dropped) + mesh.copyright.capacity() + memory_size(*mesh.library);
  for (const Dropped& entry : mesh.dropped)
    bytes += entry.what.capacity() + entry.name.capacity() + entry.reason.capacity();
  for (const EmptyNode& node : mesh.empty_nodes) bytes += node.name.capacity() + node.extras.capacity();
  for (const NodeGroup& group : mesh.groups) bytes += group.name.capacity();
  if (mesh.source_tree) {
    bytes += sizeof(SourceTree) + heap(mesh.source_tree->nodes) + heap(mesh.source_tree->of_instance);
    for (const SourceNode& node : mesh.source_tree->nodes)
      bytes += node.name.capacity() + node.extras.capacity();
  }
  const void* before = nullptr;
  for (const GivenHull& hull : mesh.given_hulls) {
    bytes += sizeof hull + hull.name.capacity() + heap(hull.points) + heap(hull.triangles);
    if (hull.owners.get() != before) bytes += heap(*hull.owners);  // the hulls of an object share the list
    before = hull.owners.get();
  }
  // Both meshes share the library, so it is counted twice. That does no harm.
  if (mesh.passed_through) bytes += memory_size(*mesh.passed_through);
  return bytes;
}

std::size_t memory_size(const PreparedMesh& mesh) {
  const Solid& solid = mesh.solid;
  std::size_t bytes = sizeof mesh + heap(solid.positions) + heap(solid.triangles) + heap(solid.wedges) +
                      heap(solid.material) + heap(solid.edges) + heap(solid.edge_vertices) +
                      heap(solid.shell) + heap(solid.part) + heap(solid.parts);
  for (const Part& part : solid.parts) bytes += heap(part.shells);
  if (solid.contacts)
    bytes += sizeof *solid.contacts + heap(solid.contacts->contacts) + heap(solid.contacts->pieces) +
             heap(solid.contacts->first_piece);
  if (solid.sheets) {
    const Solid& sheets = *solid.sheets->surface;
    bytes += sizeof(Sheets) + sizeof sheets + heap(solid.sheets->triangles) + heap(sheets.positions) +
             heap(sheets.triangles) + heap(sheets.wedges) + heap(sheets.material) + heap(sheets.edges) +
             heap(sheets.edge_vertices) + heap(sheets.shell) + heap(sheets.part);
    if (sheets.source && sheets.source != solid.source) bytes += memory_size(*sheets.source);
  }
  if (solid.instances) {
    bytes += sizeof *solid.instances + heap(solid.instances->all) + heap(solid.instances->of_part) +
             heap(solid.instances->models);
    for (const Instance& instance : solid.instances->all) bytes += heap(instance.parts);
  }
  if (solid.scenery) {
    const Solid& both = solid.scenery->both;
    bytes += sizeof both + heap(both.positions) + heap(both.triangles) + heap(both.part) + heap(both.parts) +
             heap(solid.scenery->node_of_part) + heap(both.contacts->contacts) + heap(both.contacts->pieces) +
             heap(both.contacts->first_piece);
  }
  if (solid.source) bytes += memory_size(*solid.source);
  return bytes;
}

namespace {

std::size_t memory_size(const Diagram& diagram) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  std::size_t of_sets = 0;
  for (const Diagram& set : diagram.sets) of_sets += memory_size(set);
  return of_sets + sizeof diagram + heap(diagram.sites) + heap(diagram.groups) + heap(diagram.bricks) +
         heap(t.points) + heap(t.tets) + heap(t.tet_of_site) + heap(t.site_of_input);
}

}  // namespace

std::size_t memory_size(const CutBase& base) {
  if (const auto* const diagram = std::get_if<Diagram>(&base)) return memory_size(*diagram);
  return memory_size(std::get<FracturedBase>(base));
}

std::size_t memory_size(const FractureResult& result) {
  std::size_t bytes = sizeof result + result.file.capacity() + result.parameters.capacity();
  if (!result.summary) return bytes;
  for (const auto* list : {&result.summary->remarks.warnings, &result.summary->remarks.notes})
    for (const std::string& sentence : *list) bytes += sizeof sentence + sentence.capacity();
  for (const Dropped& entry : result.summary->dropped)
    bytes += sizeof entry + entry.what.capacity() + entry.name.capacity() + entry.reason.capacity();
  return bytes;
}

}  // namespace fracture
