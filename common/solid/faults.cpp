#include "common/solid/faults.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

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

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

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

void write_notes(const EdgeFaults& faults, const SolidReport& report, std::size_t layers,
                 std::uint64_t flat_triangles, std::vector<std::string>& notes) {
  if (report.degenerate_dropped > 0)
    notes.push_back(counted(report.degenerate_dropped, "triangle with two corners at one place was",
                            "triangles with two corners at one place were") +
                    " dropped.");
  if (report.duplicates_dropped > 0)
    notes.push_back(counted(report.duplicates_dropped, "duplicate triangle was", "duplicate triangles were") +
                    " dropped.");
  if (report.welded_tolerant > 0)
    notes.push_back(counted(report.welded_tolerant, "vertex was", "vertices were") +
                    " merged with a neighbour within the weld tolerance to close open edges.");
  if (report.flipped > 0)
    notes.push_back(counted(report.flipped, "triangle was", "triangles were") + " turned to face outwards.");
  if (faults.first_nonmanifold)
    notes.push_back(
        counted(faults.nonmanifold + faults.one_way, "non-manifold edge was", "non-manifold edges were") +
        " split, the first at " + place((*faults.first_nonmanifold)[0]) + ".");
  if (report.sheets_thickened > 0)
    notes.push_back(counted(report.sheets_thickened, "open sheet was", "open sheets were") +
                    " given the thickness asked for.");
  if (report.holes_filled > 0)
    notes.push_back(
        counted(report.holes_filled, "hole was", "holes were") + " filled with " +
        counted(report.fill_triangles, "triangle", "triangles") +
        (faults.first_open ? "; the first open edge was at " + place((*faults.first_open)[0]) : "") + ".");
  if (layers > 1)
    notes.push_back("The boxes of the " + std::to_string(report.parts) + " parts overlap (" +
                    std::to_string(layers) + " layers); each part is fractured by itself.");
  if (report.shells_dropped > 0)
    notes.push_back(counted(report.shells_dropped, "piece that bounds", "pieces that bound") +
                    " no volume (flat or an open sheet, " + counted(flat_triangles, "triangle", "triangles") +
                    " when closed) " + (report.shells_dropped == 1 ? "was" : "were") + " dropped.");
}

}  // namespace fracture::solid_detail
