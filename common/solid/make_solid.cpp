// make_solid(): the stages in their order. Clean closed meshes (the common case on the timed path) skip the
// repairs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/solid/edges.hpp"
#include "common/solid/holes.hpp"
#include "common/solid/layers.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/nonmanifold.hpp"
#include "common/solid/orientation.hpp"
#include "common/solid/sheets.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/weld.hpp"

namespace fracture {
namespace {

using namespace solid_detail;

std::string place(const Vec3f& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", static_cast<double>(p.x), static_cast<double>(p.y),
                static_cast<double>(p.z));
  return text;
}

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// What is wrong with the edges, and where first.
struct EdgeFaults {
  std::uint64_t open = 0;         ///< edges with one use
  std::uint64_t nonmanifold = 0;  ///< edges with more than two
  std::uint64_t one_way = 0;      ///< edges with two uses in the same direction
  std::optional<std::array<Vec3f, 2>> first_open, first_nonmanifold;
};

EdgeFaults find_faults(const Surface& surface, const EdgeTable& edges) {
  EdgeFaults faults;
  edges.for_each([&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
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

nlohmann::json to_json(const Vec3f& p) { return {p.x, p.y, p.z}; }

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

/// Everything between the weld and a surface whose open edges only wait to be filled.
EdgeFaults repair_edges(Surface& surface, EdgeTable edges, const SolidOptions& options, double diagonal,
                        SolidReport& report, const Execution& execution) {
  const auto rebuild = [&] { edges = EdgeTable(surface, execution); };
  if (drop_duplicates(surface, edges, report)) rebuild();
  if (options.repair == Repair::kFill &&
      weld_tolerant(surface, edges, options.weld_tolerance * diagonal, report)) {
    rebuild();
    if (drop_duplicates(surface, edges, report)) rebuild();
  }
  if (orient_patches(surface, edges, report)) rebuild();
  pair_clean_edges(surface, edges);
  pair_nonmanifold_edges(surface, edges);
  return find_faults(surface, edges);
}

/// Shells become parts with cavities. Returns the part of each shell, kNoIndex for dropped ones.
std::vector<std::uint32_t> make_parts(const Shells& shells, Nesting& nesting, const Mesh& mesh,
                                      const Surface& surface, std::vector<Part>& parts) {
  const auto volume_of = [&](std::uint32_t s) {
    return (nesting.reversed[s] ? -1 : 1) * shells.list[s].volume;
  };
  const auto count = static_cast<std::uint32_t>(shells.list.size());
  // Cavities that outweigh their shell (possible only where shells cross) stand for themselves.
  std::vector<double> hollow(count, 0);
  for (std::uint32_t s = 0; s < count; ++s)
    if (nesting.cavity_of[s] != kNoIndex) hollow[nesting.cavity_of[s]] += volume_of(s);
  for (std::uint32_t s = 0; s < count; ++s)
    if (const std::uint32_t parent = nesting.cavity_of[s];
        parent != kNoIndex && volume_of(parent) + hollow[parent] <= 0) {
      nesting.cavity_of[s] = kNoIndex;
      nesting.reversed[s] ^= 1;
    }
  std::vector<std::uint32_t> part_of_shell(count, kNoIndex);
  for (std::uint32_t s = 0; s < count; ++s) {
    if (shells.list[s].flat || nesting.cavity_of[s] != kNoIndex) continue;
    part_of_shell[s] = static_cast<std::uint32_t>(parts.size());
    Part& part = parts.emplace_back();
    part.shells.push_back(s);
    part.volume = volume_of(s);
    part.box = shells.list[s].box;
    const TriangleId source = surface.source[shells.list[s].first];
    part.node = source < mesh.node.size() ? mesh.node[source] : 0;
  }
  for (std::uint32_t s = 0; s < count; ++s) {
    if (nesting.cavity_of[s] == kNoIndex) continue;
    Part& part = parts[part_of_shell[s] = part_of_shell[nesting.cavity_of[s]]];
    part.shells.push_back(s);
    part.volume += volume_of(s);
    part.box.add(shells.list[s].box);
  }
  return part_of_shell;
}

/// Final order of the triangles: by part, then as they were; dropped shells are left out.
struct Order {
  std::vector<TriangleId> place_of;  ///< kNoIndex for dropped triangles; empty when nothing moves
  TriangleId kept = 0;
};

Order final_order(const Surface& surface, const Shells& shells,
                  const std::vector<std::uint32_t>& part_of_shell, std::size_t parts) {
  const auto count = static_cast<TriangleId>(surface.triangles.size());
  if (parts == 1 && std::find(part_of_shell.begin(), part_of_shell.end(), kNoIndex) == part_of_shell.end())
    return {{}, count};
  std::vector<TriangleId> start(parts + 1, 0);
  for (TriangleId t = 0; t < count; ++t)
    if (const std::uint32_t part = part_of_shell[shells.of_triangle[t]]; part != kNoIndex) ++start[part + 1];
  for (std::size_t p = 1; p < start.size(); ++p) start[p] += start[p - 1];
  Order order{std::vector<TriangleId>(count, kNoIndex), start.back()};
  for (TriangleId t = 0; t < count; ++t)
    if (const std::uint32_t part = part_of_shell[shells.of_triangle[t]]; part != kNoIndex)
      order.place_of[t] = start[part]++;
  return order;
}

/// Moves triangles, with the twins of their half-edges, to their places.
void apply_order(Surface& surface, Shells& shells, const Order& order) {
  Surface moved;
  moved.triangles.resize(order.kept);
  moved.source.resize(order.kept);
  moved.twin.resize(3 * static_cast<std::size_t>(order.kept));
  if (!surface.flipped.empty()) moved.flipped.resize(order.kept);
  std::vector<std::uint32_t> shell(order.kept);
  for (TriangleId t = 0; t < order.place_of.size(); ++t) {
    const TriangleId to = order.place_of[t];
    if (to == kNoIndex) continue;
    moved.triangles[to] = surface.triangles[t];
    moved.source[to] = surface.source[t];
    shell[to] = shells.of_triangle[t];
    if (!surface.flipped.empty()) moved.flipped[to] = surface.flipped[t];
    for (HalfEdge k = 0; k < 3; ++k) {  // glued triangles are of one shell, so the twin was kept as well
      const HalfEdge twin = surface.twin[3 * t + k];
      moved.twin[3 * to + k] = 3 * order.place_of[twin / 3] + twin % 3;
    }
  }
  surface.triangles = std::move(moved.triangles);
  surface.source = std::move(moved.source);
  surface.twin = std::move(moved.twin);
  surface.flipped = std::move(moved.flipped);
  shells.of_triangle = std::move(shell);
}

void drop_unused_vertices(Surface& surface) {
  std::vector<VertexId> new_vertex(surface.positions.size(), kNoIndex);
  for (const Triangle& t : surface.triangles)
    for (const VertexId v : t) new_vertex[v] = 0;
  VertexId kept = 0;
  for (VertexId v = 0; v < new_vertex.size(); ++v) {
    if (new_vertex[v] == kNoIndex) continue;
    new_vertex[v] = kept;
    surface.positions[kept++] = surface.positions[v];
  }
  surface.positions.resize(kept);
  for (Triangle& t : surface.triangles)
    for (VertexId& v : t) v = new_vertex[v];
}

/// The ordered surface with the ids every later stage uses. Edges are numbered in the order the triangles
/// meet them.
void write_out(const Mesh& mesh, Surface& surface, Shells& shells,
               const std::vector<std::uint32_t>& part_of_shell, const std::vector<std::uint32_t>& new_shell,
               Solid& solid) {
  const std::size_t count = surface.triangles.size();
  solid.wedges.resize(count);
  solid.material.resize(count);
  solid.edges.resize(count);
  solid.part.resize(count);
  solid.edge_vertices.reserve(3 * count / 2);
  for (TriangleId t = 0; t < count; ++t) {
    solid.part[t] = part_of_shell[shells.of_triangle[t]];
    shells.of_triangle[t] = new_shell[shells.of_triangle[t]];
    const TriangleId source = surface.source[t];
    if (source == kNoIndex) {
      solid.wedges[t] = {kNoIndex, kNoIndex, kNoIndex};
      solid.material[t] = kInteriorMaterial;
    } else {
      solid.wedges[t] = mesh.triangles[source];
      if (!surface.flipped.empty() && surface.flipped[t]) std::swap(solid.wedges[t][1], solid.wedges[t][2]);
      solid.material[t] = source < mesh.material.size() ? mesh.material[source] : kNoIndex;
    }
    for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
      const HalfEdge twin = surface.twin[h];
      if (twin < h) {
        solid.edges[t][h - 3 * t] = solid.edges[twin / 3][twin % 3];
        continue;
      }
      const VertexId a = surface.from(h), b = surface.to(h);
      solid.edges[t][h - 3 * t] = static_cast<std::uint32_t>(solid.edge_vertices.size());
      solid.edge_vertices.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  solid.positions = std::move(surface.positions);
  solid.triangles = std::move(surface.triangles);
  solid.shell = std::move(shells.of_triangle);
}

void write_notes(const EdgeFaults& faults, const SolidReport& report, std::size_t overlapping,
                 std::vector<std::string>& notes) {
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
  if (overlapping > 1)
    notes.push_back("The boxes of the " + std::to_string(report.parts) + " parts overlap (" +
                    std::to_string(overlapping) + " layers); each part is fractured by itself.");
}

}  // namespace

Expected<Solid> make_solid(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                           const Execution& execution) {
  Solid solid;
  SolidReport& report = solid.report;
  Expected<Surface> welded = weld_exact(*mesh, report, execution);
  if (!welded) return tl::unexpected(std::move(welded.error()));
  Surface& surface = *welded;

  EdgeFaults faults;
  if (!pair_closed_manifold(surface, execution)) {
    EdgeTable edges(surface, execution);
    if (!pair_clean_edges(surface, edges)) {
      Box box;
      for (const Vec3f& p : surface.positions) box.add(to_double(p));
      faults = repair_edges(surface, std::move(edges), options, length(box.size()), report, execution);
    }
  }
  report.open_edges = faults.open;
  if (faults.first_open) report.add_sample("open_edges", (*faults.first_open)[0]);
  if (faults.first_nonmanifold) report.add_sample("nonmanifold_edges", (*faults.first_nonmanifold)[0]);
  report.nonmanifold_edges = faults.nonmanifold + faults.one_way;
  bool open = false;
  if (report.open_edges + report.nonmanifold_edges > 0)
    for (const HalfEdge twin : surface.twin) open |= twin == kNoIndex;
  if (options.repair == Repair::kStrict && (open || report.flipped > 0))
    return refuse(open
                      ? "The mesh is not closed and repair=strict fills nothing: " +
                            counted(faults.open, "open edge", "open edges") + ", " +
                            counted(report.nonmanifold_edges, "non-manifold edge", "non-manifold edges") + "."
                      : "The mesh is closed but not consistently oriented and repair=strict turns nothing: " +
                            counted(report.flipped, "triangle faces", "triangles face") + " the other way.",
                  faults, report);

  std::vector<TriangleId> fills;
  if (open) fills = fill_holes(surface, execution);
  split_umbrellas(surface, execution);

  Shells shells = find_shells(surface, execution);
  if (options.thickness > 0) {
    report.sheets_thickened = thicken_sheets(surface, shells, options.thickness, fills, execution);
    if (report.sheets_thickened > 0) {
      split_umbrellas(surface, execution);
      shells = find_shells(surface, execution);
    }
  }
  Nesting nesting = nest_shells(surface, shells, execution);
  const std::vector<std::uint32_t> part_of_shell = make_parts(shells, nesting, *mesh, surface, solid.parts);
  for (std::uint32_t s = 0; s < shells.list.size(); ++s) report.shells_dropped += shells.list[s].flat;
  if (solid.parts.empty())
    return refuse("The mesh bounds no volume: closed at its holes it is flat in " +
                      counted(report.shells_dropped, "piece", "pieces") + " (" +
                      counted(faults.open, "open edge", "open edges") + ", " +
                      counted(report.nonmanifold_edges, "non-manifold edge", "non-manifold edges") + ").",
                  faults, report);
  std::uint64_t inside_out = 0;
  for (std::uint32_t s = 0; s < shells.list.size(); ++s)
    if (nesting.reversed[s]) inside_out += shells.list[s].triangles;
  if (inside_out > 0) {
    if (options.repair == Repair::kStrict) {
      report.flipped = inside_out;
      return refuse("The mesh is closed but inside out and repair=strict turns nothing: " +
                        counted(inside_out, "triangle faces", "triangles face") + " inwards.",
                    faults, report);
    }
    for (TriangleId t = 0; t < surface.triangles.size(); ++t) {
      if (!nesting.reversed[shells.of_triangle[t]]) continue;
      report.add_sample("flipped", surface.positions[surface.triangles[t][0]]);
      surface.flip(t);
      // The half-edges ab, bc, ca became ac, cb, ba: the first and the last change places.
      std::swap(surface.twin[3 * t], surface.twin[3 * t + 2]);
    }
    for (HalfEdge& twin : surface.twin)
      if (nesting.reversed[shells.of_triangle[twin / 3]] && twin % 3 != 1)
        twin = twin - twin % 3 + (2 - twin % 3);
    report.flipped += inside_out;
  }

  // Shells keep their order; dropped ones lose their numbers.
  std::vector<std::uint32_t> new_shell(shells.list.size(), kNoIndex);
  std::uint64_t flat_triangles = 0;
  for (std::uint32_t s = 0; s < shells.list.size(); ++s) {
    if (shells.list[s].flat) {
      flat_triangles += shells.list[s].triangles;
      report.add_sample("shells_dropped", surface.positions[surface.triangles[shells.list[s].first][0]]);
      continue;
    }
    new_shell[s] = static_cast<std::uint32_t>(report.shells++);
    report.area += shells.list[s].area;
    report.absolute_volume += std::fabs(shells.list[s].volume);
  }
  for (Part& part : solid.parts) {
    report.cavities += part.shells.size() - 1;
    report.volume += part.volume;
    for (std::uint32_t& s : part.shells) s = new_shell[s];
    solid.box.add(part.box);
  }
  report.parts = solid.parts.size();
  solid.layers = assign_layers(solid.parts, execution);
  for (const TriangleId fill : fills) {
    if (shells.list[shells.of_triangle[fill]].flat) continue;
    if (report.holes_filled++ == 0)
      report.add_sample("holes_filled", surface.positions[surface.triangles[fill][0]]);
  }
  for (TriangleId t = 0; open + report.sheets_thickened > 0 && t < surface.triangles.size(); ++t) {
    if (surface.source[t] != kNoIndex || shells.list[shells.of_triangle[t]].flat) continue;
    ++report.fill_triangles;
    const Triangle& corners = surface.triangles[t];
    const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                c = to_double(surface.positions[corners[2]]);
    report.filled_area += 0.5 * length(cross(b - a, c - a));
  }
  const Order order = final_order(surface, shells, part_of_shell, solid.parts.size());
  if (!order.place_of.empty()) apply_order(surface, shells, order);
  if (report.degenerate_dropped + report.duplicates_dropped + report.welded_tolerant + report.shells_dropped +
          report.sheets_thickened >
      0)
    drop_unused_vertices(surface);
  write_out(*mesh, surface, shells, part_of_shell, new_shell, solid);
  write_notes(faults, report, solid.layers, report.notes);
  if (report.shells_dropped > 0)
    report.notes.push_back(counted(report.shells_dropped, "piece that bounds", "pieces that bound") +
                           " no volume (flat or an open sheet, " +
                           counted(flat_triangles, "triangle", "triangles") + " when closed) " +
                           (report.shells_dropped == 1 ? "was" : "were") + " dropped.");
  solid.source = std::move(mesh);
  return solid;
}

}  // namespace fracture
