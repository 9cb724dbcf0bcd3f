#include "common/solid/faults.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"

namespace fracture::solid_detail {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string place(const Vec3f& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", static_cast<double>(p.x), static_cast<double>(p.y),
                static_cast<double>(p.z));
  return text;
}

namespace {

nlohmann::json to_json(const Vec3f& p) { return {p.x, p.y, p.z}; }

}  // namespace

EdgeFaults find_faults(const Surface& surface, const EdgeTable& edges, const Execution& execution) {
  EdgeFaults faults;
  edges.for_each(execution, [&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
    const std::array<Vec3f, 2> ends{surface.positions[a], surface.positions[b]};
    if (uses.size() == 1) {
      if (faults.open++ == 0) faults.first_open = ends;
    } else if (uses.size() > 2) {
      if (faults.nonmanifold++ == 0) faults.first_nonmanifold = ends;
    } else if (uses[0].backward() == uses[1].backward()) {
      if (faults.one_way++ == 0 && !faults.first_nonmanifold) faults.first_nonmanifold = ends;
    }
  });
  return faults;
}

tl::unexpected<Error> refuse(std::string detail, const EdgeFaults& faults, const SolidReport& report) {
  nlohmann::json extra = {{"open_edges", faults.open},
                          {"nonmanifold_edges", faults.nonmanifold},
                          {"flipped", report.flipped},
                          {"source_triangles", report.source_triangles}};
  const auto& ends = faults.first_open ? faults.first_open : faults.first_nonmanifold;
  if (ends) {
    detail += " The first such edge runs from " + place((*ends)[0]) + " to " + place((*ends)[1]) + ".";
    extra["sample"] = to_json((*ends)[0]);
    extra["edge"] = {to_json((*ends)[0]), to_json((*ends)[1])};
  }
  return fail(ErrorCode::kMeshNotClosed, std::move(detail), {}, std::move(extra));
}

void write_remarks(const EdgeFaults& faults, const SolidReport& report, std::size_t layers,
                   const FlatPieces& flat, const SolidOptions& options, Remarks& remarks) {
  const double thickness = options.thickness;
  if (report.degenerate_dropped > 0)
    remarks.note(counted(report.degenerate_dropped, "triangle with two corners at the same position was",
                         "triangles with two corners at the same position were") +
                 " left out.");
  if (report.duplicates_dropped > 0)
    remarks.note(counted(report.duplicates_dropped, "duplicate triangle was", "duplicate triangles were") +
                 " left out.");
  if (report.welded_tolerant > 0)
    remarks.note(counted(report.welded_tolerant, "vertex was", "vertices were") +
                 " merged with a neighbour within the weld tolerance to close open edges.");
  if (report.flipped > 0)
    remarks.note(counted(report.flipped, "triangle was", "triangles were") + " turned to face outwards.");
  if (faults.first_nonmanifold) {
    const std::uint64_t split = faults.nonmanifold + faults.one_way;
    remarks.note(counted(split, "non-manifold edge was", "non-manifold edges were") + " split, " +
                 (split == 1 ? "at " : "the first at ") + place((*faults.first_nonmanifold)[0]) + ".");
  }
  const std::string of_thickness =
      std::string(" with ") +
      (options.sheets == SheetsMode::kSolid ? "a thickness of " : "the given 'thickness', ") +
      short_number(thickness) + " m";
  if (const std::uint64_t sheets = report.sheets_thickened - report.rooms_walled; sheets > 0)
    remarks.note(counted(sheets, "open sheet became a slab", "open sheets became slabs") + of_thickness +
                 ".");
  if (report.rooms_walled > 0)
    remarks.note(counted(report.rooms_walled, "closed piece faces", "closed pieces face") +
                 " inwards, like a room that is seen from inside. " +
                 (report.rooms_walled == 1 ? "It got walls" : "They got walls") + of_thickness +
                 ", on the outside of the faces.");
  if (report.holes_filled > 0)
    remarks.note(counted(report.holes_filled, "hole was", "holes were") + " filled with " +
                 counted(report.fill_triangles, "triangle", "triangles") + " in the material of cut faces" +
                 (faults.first_open ? "; the first open edge was at " + place((*faults.first_open)[0]) : "") +
                 ".");
  if (layers > 1)
    remarks.note("Some bounding boxes of the " + grouped(report.parts) +
                 " parts overlap. The report lists the parts that touch or overlap.");
  const std::string them = report.shells_dropped == 1 ? "it" : "them";
  if (flat.triangles > 0 && report.sheets > 0)
    remarks.note(counted(report.sheets, "sheet", "sheets") + " without a volume (" + grouped(flat.triangles) +
                 " of " + counted(report.source_triangles, "triangle", "triangles") + ", the first at " +
                 place(flat.first) +
                 (flat.node.empty() ? "" : " in the node \"" + shortened(flat.node) + "\"") + ") " +
                 (options.sheets == SheetsMode::kWhole
                      ? (report.sheets == 1 ? "stays whole, next to the fragments."
                                            : "stay whole, next to the fragments.")
                      : (report.sheets == 1 ? "is cut with the solid, and fragments carry its pieces."
                                            : "are cut with the solid, and fragments carry their pieces.")) +
                 " With sheets=solid, sheets become slabs.");
  if (flat.triangles > 0 && report.sheets == 0)
    remarks.warn(
        counted(report.shells_dropped, "thin piece", "thin pieces") + " (" + grouped(flat.triangles) +
        " of " + counted(report.source_triangles, "triangle", "triangles") + ", the first at " +
        place(flat.first) + (flat.node.empty() ? "" : " in the node \"" + shortened(flat.node) + "\"") +
        ") " + (report.shells_dropped == 1 ? "has no volume and is" : "have no volume and are") +
        " not in the answer. " +
        (thickness > 0 ? "No slab could be made from "
                       : std::string("Use 'thickness' to make ") +
                             (report.shells_dropped == 1 ? "a slab from " : "slabs from ")) +
        them + (thickness > 0 ? ": give " : ", or give ") + them + " a volume in a modelling tool.");
}

}  // namespace fracture::solid_detail
