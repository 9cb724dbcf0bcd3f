#include "server/service/mesh_report.hpp"

#include "common/contacts/contact_report.hpp"
#include "common/gltf/report_text.hpp"
#include "common/mesh/material_library.hpp"
#include "common/pipeline/overlaps.hpp"

namespace fracture {
namespace {

nlohmann::json material_names(const Mesh& mesh) {
  nlohmann::json names = nlohmann::json::array();
  for (const auto& material : mesh.library->materials)
    names.push_back(material.contains("name") ? material["name"] : nlohmann::json());
  return names;
}

}  // namespace

bool repaired(const SolidReport& r) {
  return r.open_edges + r.nonmanifold_edges + r.flipped + r.degenerate_dropped + r.duplicates_dropped +
             r.welded_tolerant + r.holes_filled + r.sheets_thickened + r.sheets + r.shells_dropped >
         0;
}

nlohmann::json mesh_report(const PreparedMesh& mesh) {
  const Mesh& source = *mesh.solid.source;
  const Remarks remarks = mesh.solid.remarks();
  nlohmann::json report = {{"verdict", repaired(mesh.solid.report) ? "repaired" : "closed"},
                           {"solid", mesh.solid.report.to_json()},
                           {"volume_once", volume_once(mesh.solid, {})},
                           {"frame", mesh.frame},
                           {"nodes", source.node_names},
                           {"materials", material_names(source)},
                           {"images", source.library->images.size()},
                           {"warnings", remarks.warnings},
                           {"notes", remarks.notes},
                           {"choices", choices_document(mesh.solid.report.choices)}};
  if (!source.dropped.empty()) report["dropped"] = dropped_document(source.dropped);
  if (!source.groups.empty()) {
    nlohmann::json groups = nlohmann::json::array();
    for (const NodeGroup& group : source.groups) groups.push_back(group.name);
    report["groups"] = std::move(groups);
  }
  if (const auto contacts = contact_report(mesh.solid)) report["contacts"] = contacts_document(*contacts);
  if (source.passed_through)
    report["passed_through"] = {{"triangles", source.passed_through->triangles.size()}};
  return report;
}

}  // namespace fracture
