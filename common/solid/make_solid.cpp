// make_solid(): runs the stages in order. Clean closed meshes (the common case, whose speed matters) skip the
// repairs.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/words.hpp"
#include "common/solid/doubled_vessels.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/enclosures.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/holes.hpp"
#include "common/solid/layers.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/nonmanifold.hpp"
#include "common/solid/orientation.hpp"
#include "common/solid/part_colors.hpp"
#include "common/solid/parts.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/seams.hpp"
#include "common/solid/sheet_surface.hpp"
#include "common/solid/sheets.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/weld.hpp"

namespace fracture {
namespace {

using namespace solid_detail;

/// Half-edges are numbered in 32 bits, or in 31 with a direction. Repairs can turn one triangle into at most
/// itself, three triangles that fill its open edges, a back, and three walls.
constexpr std::size_t kMostTriangles = (std::size_t{1} << 31) / (3 * 12);

Box box_of(const Surface& surface, const Execution& execution) {
  Box box;
  for_each_polled(execution, surface.positions.size(),
                  [&](std::size_t v) { box.add(to_double(surface.positions[v])); });
  return box;
}

double reach_of(const Box& box, int axis) {
  return std::fmax(std::fabs(box.min[axis]), std::fabs(box.max[axis]));
}

/// Maximum distance between vertices to weld, m.
double weld_distance(const Box& box, const SolidOptions& options) {
  return options.weld_tolerance * length(box.size());
}

/// Maximum distance of a seam's vertices from its line, m. If positive, at least the error from rounding to
/// floats.
double seam_distance(const Box& box, const SolidOptions& options) {
  if (options.weld_tolerance <= 0) return 0;
  const double reach = length({reach_of(box, 0), reach_of(box, 1), reach_of(box, 2)});
  return std::fmax(weld_distance(box, options), 0x1p-23 * reach);
}

/// Whether open pieces are closed by filling their holes. Otherwise, they are refused, or walls are wanted, which have two sides.
bool fills_vessels(const SolidOptions& options) {
  return options.repair == Repair::kFill && options.thickness <= 0 && options.sheets != SheetsMode::kSolid;
}

/// Glues all edges that can be paired. The remaining open edges are filled later.
EdgeFaults pair_edges(Surface& surface, const SolidOptions& options, SolidReport& report,
                      const Execution& execution) {
  if (pair_closed_manifold(surface, execution)) return {};
  EdgeTable edges(surface, execution);
  if (pair_clean_edges(surface, edges, execution)) return {};
  const auto rebuild = [&] { edges = EdgeTable(surface, execution); };
  if (drop_duplicates(surface, edges, report, execution)) rebuild();
  if (options.repair == Repair::kFill &&
      weld_tolerant(surface, edges, weld_distance(box_of(surface, execution), options), report, execution)) {
    rebuild();
    if (drop_duplicates(surface, edges, report, execution)) rebuild();
  }
  if (fills_vessels(options) &&
      drop_inner_sides(surface, edges, seam_distance(box_of(surface, execution), options), report, execution))
    rebuild();
  if (orient_patches(surface, edges, report, execution)) rebuild();
  pair_clean_edges(surface, edges, execution);
  pair_nonmanifold_edges(surface, edges, execution);
  const EdgeFaults faults = find_faults(surface, edges, execution);
  if (options.repair == Repair::kFill && faults.open > 0)
    offer_welding(surface, edges, length(box_of(surface, execution).size()), options.weld_tolerance, report,
                  execution);
  return faults;
}

bool any_open(const Surface& surface, const Execution& execution) {
  bool open = false;
  for_each_polled(execution, surface.twin.size(),
                  [&](std::size_t h) { open |= surface.twin[h] == kNoIndex; });
  return open;
}

void report_edges(const EdgeFaults& faults, SolidReport& report) {
  report.open_edges = faults.open;
  report.nonmanifold_edges = faults.nonmanifold + faults.one_way;
  if (faults.first_open) report.add_sample("open_edges", (*faults.first_open)[0]);
  if (faults.first_nonmanifold) report.add_sample("nonmanifold_edges", (*faults.first_nonmanifold)[0]);
}

std::string edges_in_words(const SolidReport& report) {
  return counted(report.open_edges, "open edge", "open edges") + ", " +
         counted(report.nonmanifold_edges, "non-manifold edge", "non-manifold edges");
}

/// Refuses meshes that repair=strict would have to change.
Expected<void> accept_strictly(bool open, const EdgeFaults& faults, const SolidReport& report) {
  if (open)
    return refuse("The mesh is not closed, and repair=strict fills no holes: " + edges_in_words(report) + ".",
                  faults, report);
  if (report.flipped > 0)
    return refuse("The mesh is closed but not consistently oriented, and repair=strict turns no triangles: " +
                      counted(report.flipped, "triangle faces", "triangles face") + " the other way.",
                  faults, report);
  return {};
}

/// Thickness of slabs, m. 0: sheets do not become slabs.
double thickness_of(const Surface& surface, const SolidOptions& options, const Execution& execution) {
  if (options.thickness > 0 || options.sheets != SheetsMode::kSolid) return options.thickness;
  return kSlabShare * length(box_of(surface, execution).size());
}

/// The closed surface, and its pieces with large lids (before sheets are thickened).
struct Closed {
  Shells shells;
  Enclosures lids;
};

/// Returns the rooms, of which `thickness` makes walls. repair=strict refuses them.
Enclosures rooms_to_wall(const Surface& surface, const Closed& closed, const SolidOptions& options,
                         const Execution& execution) {
  const auto is_inward = [](const Shell& shell) { return !shell.flat && shell.volume < 0; };
  const std::vector<Shell>& list = closed.shells.list;
  if (options.repair == Repair::kStrict || std::none_of(list.begin(), list.end(), is_inward)) return {};
  return find_rooms(closed.shells, nest_shells(surface, closed.shells, execution), closed.lids, execution);
}

/// Fills the holes, splits the umbrellas and thickens the sheets.
Closed close_surface(Surface& surface, bool open, const SolidOptions& options, std::vector<TriangleId>& fills,
                     SolidReport& report, const Execution& execution) {
  if (open) {
    const double distance = seam_distance(box_of(surface, execution), options);
    weld_ends_of_seams(surface, distance, report, execution);
    fills = fill_holes(surface, distance, execution);
  }
  split_umbrellas(surface, execution);
  Closed closed{find_shells(surface, execution), {}};
  closed.lids = find_large_lids(surface, closed.shells, fills, execution);
  if (options.thickness > 0) {
    const Enclosures rooms = rooms_to_wall(surface, closed, options, execution);
    report.sheets_thickened = thicken_sheets(surface, closed.shells, options.thickness,
                                             {closed.lids.has, rooms.has}, fills, report, execution);
    if (report.sheets_thickened > 0) {
      split_umbrellas(surface, execution);
      closed.shells = find_shells(surface, execution);
    }
  }
  return closed;
}

/// Checks that the solid is large enough on each axis. A solid cannot be flat on any axis.
Expected<void> accept_reach(const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = reach_of(box, axis);
    if (reach >= kLeastReach) continue;
    const std::string name(1, "xyz"[axis]);
    return fail(ErrorCode::kNotFinite,
                "The solid is too small: along the " + name + " axis, it reaches only " + number(reach) +
                    " m from 0, and the minimum is " + number(kLeastReach) +
                    " m. Give the unit of the file with 'unit', or scale the mesh up.",
                {}, {{"axis", name}, {"reach", reach}});
  }
  return {};
}

/// Says why no shell bounds a volume, and what to do.
std::string why_no_volume(const Surface& surface, const Shells& shells, const SolidReport& report,
                          const Execution& execution) {
  const std::string pieces = counted(report.shells_dropped, "piece", "pieces");
  if (report.open_edges + report.nonmanifold_edges > 0)
    return "after closing its holes, " + pieces + (report.shells_dropped == 1 ? " is" : " are") + " flat (" +
           edges_in_words(report) +
           "). Use sheets=solid to give sheets a volume, or 'thickness' to choose how thick they become.";
  if (count_cancelling(surface, shells, execution) > 0)
    return "it is closed (" + pieces +
           "), but parts of opposite winding cancel each other out, or its two sides coincide. Repair "
           "the mesh in a modelling tool, so that all its parts face outwards.";
  return "it is closed (" + pieces +
         "), but thinner than the precision of its coordinates. Make it thicker in a modelling tool.";
}

/// Groups the shells into parts, and turns those that face the wrong way. Returns the part of each shell.
/// Errors: kMeshNotClosed if no shell bounds a volume, or if repair=strict would have to turn one.
Expected<std::vector<std::uint32_t>> divide_into_parts(const Mesh& mesh, const EdgeFaults& faults,
                                                       const SolidOptions& options, Surface& surface,
                                                       const Closed& closed, Solid& solid,
                                                       const Execution& execution) {
  const Shells& shells = closed.shells;
  SolidReport& report = solid.report;
  Nesting nesting = nest_shells(surface, shells, execution);
  if (options.thickness <= 0) {
    offer_walls_of_rooms(find_rooms(shells, nesting, closed.lids, execution), surface, report);
    offer_walls_instead_of_lids(closed.lids, surface, report);
  }
  std::vector<std::uint32_t> part_of_shell =
      make_parts(shells, nesting, mesh, surface, solid.parts, execution);
  std::uint64_t inside_out = 0;
  for_each_polled(execution, shells.list.size(), [&](std::size_t s) {
    report.shells_dropped += shells.list[s].flat;
    if (!nesting.reversed[s]) return;
    if (inside_out == 0)
      report.add_sample("flipped", surface.positions[surface.triangles[shells.list[s].first][0]]);
    inside_out += shells.list[s].triangles;
  });
  if (solid.parts.empty())
    return refuse("The mesh has no volume: " + why_no_volume(surface, shells, report, execution), faults,
                  report);
  if (inside_out == 0) return part_of_shell;
  if (options.repair == Repair::kStrict) {
    report.flipped = inside_out;
    return refuse("The mesh is closed but inside out, and repair=strict does not flip triangles: " +
                      counted(inside_out, "triangle faces", "triangles face") + " inwards.",
                  faults, report);
  }
  turn_shells(surface, shells, nesting.reversed, execution);
  report.flipped += inside_out;
  return part_of_shell;
}

/// Reports the fills of holes, and the backs and rims of sheets, in the remaining shells.
void report_fills(const Surface& surface, const Shells& shells, const std::vector<TriangleId>& fills,
                  SolidReport& report, const Execution& execution) {
  for_each_polled(execution, fills.size(), [&](std::size_t i) {
    if (shells.list[shells.of_triangle[fills[i]]].flat) return;
    if (report.holes_filled++ == 0)
      report.add_sample("holes_filled", surface.positions[surface.triangles[fills[i]][0]]);
  });
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    if (surface.source[t] != kNoIndex || shells.list[shells.of_triangle[t]].flat) return;
    ++report.fill_triangles;
    const Triangle& corners = surface.triangles[t];
    const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                c = to_double(surface.positions[corners[2]]);
    report.filled_area += 0.5 * length(cross(b - a, c - a));
  });
}

/// Whether sheets stay in the answer.
bool keeps_sheets(const SolidOptions& options) {
  return options.thickness == 0 &&
         (options.sheets == SheetsMode::kAttach || options.sheets == SheetsMode::kWhole);
}

/// Finds the source triangles of the flat shells, and keeps them as sheets if that was asked for. Shells that are
/// kept no longer count as dropped.
void keep_sheets(const std::shared_ptr<const Mesh>& mesh, const Surface& surface, const Shells& shells,
                 const SolidOptions& options, Solid& solid, const Execution& execution) {
  SolidReport& report = solid.report;
  std::vector<std::uint32_t> triangles;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    if (surface.source[t] != kNoIndex && shells.list[shells.of_triangle[t]].flat)
      triangles.push_back(surface.source[t]);
  });
  sort_with_polls(execution, triangles.begin(), triangles.end());
  const std::shared_ptr<const Sheets> sheets =
      make_sheets(mesh, triangles, solid.box, options.sheets == SheetsMode::kWhole, execution);
  if (!sheets) return;
  report.sheet_triangles = sheets->triangles.size();
  report.sheet_area = sheets->area;
  if (!keeps_sheets(options)) return;
  report.sheets = std::exchange(report.shells_dropped, 0);
  solid.sheets = sheets;
}

/// Counts triangles in flat shells, before the surface is grouped by parts.
FlatPieces flat_pieces(const Mesh& mesh, const Surface& surface, const Shells& shells,
                       const SolidReport& report, const Execution& execution) {
  FlatPieces flat;
  if (report.shells_dropped + report.sheets == 0) return flat;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const std::uint32_t source = surface.source[t];
    if (source == kNoIndex || !shells.list[shells.of_triangle[t]].flat) return;
    if (flat.triangles++ > 0) return;
    flat.first = surface.positions[surface.triangles[t][0]];
    if (source < mesh.node.size() && mesh.node[source] < mesh.node_names.size())
      flat.node = mesh.node_names[mesh.node[source]];
  });
  return flat;
}

/// Numbers the shells in their order; flat ones get no number. Counts both kinds.
std::vector<std::uint32_t> number_shells(const Surface& surface, const Shells& shells, SolidReport& report,
                                         const Execution& execution) {
  bool any_flat = false;
  std::vector<std::uint32_t> numbers = filled(execution, shells.list.size(), kNoIndex);
  for_each_polled(execution, shells.list.size(), [&](std::size_t s) {
    const Shell& shell = shells.list[s];
    if (shell.flat) {
      if (!std::exchange(any_flat, true))
        report.add_sample(report.sheets > 0 ? "sheets" : "shells_dropped",
                          surface.positions[surface.triangles[shell.first][0]]);
      return;
    }
    numbers[s] = static_cast<std::uint32_t>(report.shells++);
    report.area += shell.area;
    report.absolute_volume += std::fabs(shell.volume);
  });
  return numbers;
}

/// Builds the solid from the shells. The solid takes over the arrays of the surface.
void finish(const Mesh& mesh, Surface& surface, Shells& shells,
            const std::vector<std::uint32_t>& part_of_shell, const std::vector<TriangleId>& fills,
            bool filled_any, const EdgeFaults& faults, const SolidOptions& options, Solid& solid,
            const Execution& execution) {
  SolidReport& report = solid.report;
  const FlatPieces flat = flat_pieces(mesh, surface, shells, report, execution);
  const std::vector<std::uint32_t> new_shell = number_shells(surface, shells, report, execution);
  for_each_polled(execution, solid.parts.size(), [&](std::size_t p) {
    Part& part = solid.parts[p];
    report.cavities += part.shells.size() - 1;
    report.volume += part.volume;
    for (std::uint32_t& s : part.shells) s = new_shell[s];
  });
  report.parts = solid.parts.size();
  solid.layers = assign_layers(solid.parts, execution);
  if (filled_any) report_fills(surface, shells, fills, report, execution);
  group_by_part(surface, shells, part_of_shell, solid.parts.size(), execution);
  if (report.degenerate_dropped + report.duplicates_dropped + report.welded_tolerant + report.shells_dropped +
          report.sheets + report.sheets_thickened >
      0)
    drop_unused_vertices(surface, execution);
  write_out(mesh, surface, shells, part_of_shell, new_shell, solid, execution);
  color_parts(mesh, surface.source, solid, execution);
  write_remarks(faults, report, solid.layers, flat, options, report.remarks);
}

}  // namespace

Expected<Solid> make_solid(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                           const Execution& execution) {
  if (mesh->triangles.size() > kMostTriangles)
    return fail(ErrorCode::kTooLarge, "The mesh has " + grouped(mesh->triangles.size()) +
                                          " triangles; the limit for a solid is " + grouped(kMostTriangles) +
                                          ". Reduce the mesh, or divide it into several files.");
  Solid solid;
  SolidReport& report = solid.report;
  execution.reaches(0.4);
  Expected<Surface> welded = weld_exact(*mesh, report, execution);
  if (!welded) return tl::unexpected(std::move(welded.error()));
  Surface& surface = *welded;

  execution.reaches(0.7);
  const EdgeFaults faults = pair_edges(surface, options, report, execution);
  report_edges(faults, report);
  const bool open = report.open_edges + report.nonmanifold_edges > 0 && any_open(surface, execution);
  if (options.repair == Repair::kStrict)
    if (Expected<void> accepted = accept_strictly(open, faults, report); !accepted)
      return tl::unexpected(std::move(accepted.error()));

  std::vector<TriangleId> fills;
  SolidOptions used = options;
  used.thickness = thickness_of(surface, options, execution);
  Closed closed = close_surface(surface, open, used, fills, report, execution);
  execution.reaches(1);
  const Expected<std::vector<std::uint32_t>> part_of_shell =
      divide_into_parts(*mesh, faults, used, surface, closed, solid, execution);
  if (!part_of_shell) return tl::unexpected(part_of_shell.error());
  for_each_polled(execution, solid.parts.size(), [&](std::size_t p) { solid.box.add(solid.parts[p].box); });
  if (Expected<void> accepted = accept_reach(solid.box); !accepted)
    return tl::unexpected(std::move(accepted.error()));
  if (report.shells_dropped > 0) keep_sheets(mesh, surface, closed.shells, options, solid, execution);
  finish(*mesh, surface, closed.shells, *part_of_shell, fills, open || report.sheets_thickened > 0, faults,
         used, solid, execution);
  solid.source = std::move(mesh);
  return solid;
}

}  // namespace fracture
