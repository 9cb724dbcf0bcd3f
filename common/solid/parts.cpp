#include "common/solid/parts.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

std::vector<std::uint32_t> make_parts(const Shells& shells, Nesting& nesting, const Mesh& mesh,
                                      const Surface& surface, std::vector<Part>& parts,
                                      const Execution& execution) {
  const auto volume_of = [&](std::uint32_t s) {
    return (nesting.reversed[s] ? -1 : 1) * shells.list[s].volume;
  };
  const auto count = static_cast<std::uint32_t>(shells.list.size());
  std::vector<double> hollow = filled<double>(execution, count, 0);
  Pacer pacer(execution);
  for (std::uint32_t s = 0; s < count; ++s) {
    pacer.step();
    if (nesting.cavity_of[s] != kNoIndex) hollow[nesting.cavity_of[s]] += volume_of(s);
  }
  for (std::uint32_t s = 0; s < count; ++s) {
    pacer.step();
    if (const std::uint32_t parent = nesting.cavity_of[s];
        parent != kNoIndex && volume_of(parent) + hollow[parent] <= 0) {
      nesting.cavity_of[s] = kNoIndex;
      nesting.reversed[s] ^= 1;
    }
  }
  std::vector<std::uint32_t> part_of_shell = filled(execution, count, kNoIndex);
  std::size_t outward = 0;
  for (std::uint32_t s = 0; s < count; ++s)
    outward += !shells.list[s].flat && nesting.cavity_of[s] == kNoIndex;
  parts.reserve(outward);
  for (std::uint32_t s = 0; s < count; ++s) {
    pacer.step(4);  // counts more than one step because it allocates
    if (shells.list[s].flat || nesting.cavity_of[s] != kNoIndex) continue;
    part_of_shell[s] = static_cast<std::uint32_t>(parts.size());
    Part& part = parts.emplace_back();
    part.shells.push_back(s);
    part.volume = volume_of(s);
    part.box = shells.list[s].box;
    const std::uint32_t source = surface.source[shells.list[s].first];
    part.node = source < mesh.node.size() ? mesh.node[source] : 0;
  }
  for (std::uint32_t s = 0; s < count; ++s) {
    pacer.step(4);
    if (nesting.cavity_of[s] == kNoIndex) continue;
    Part& part = parts[part_of_shell[s] = part_of_shell[nesting.cavity_of[s]]];
    part.shells.push_back(s);
    part.volume += volume_of(s);
    part.box.add(shells.list[s].box);
  }
  pacer.each(0, surface.triangles.size(), [&](std::size_t t) {
    const std::uint32_t part = part_of_shell[shells.of_triangle[t]], source = surface.source[t];
    if (part != kNoIndex && source < mesh.node.size()) parts[part].nodes.add(mesh.node[source]);
  });
  return part_of_shell;
}

void turn_shells(Surface& surface, const Shells& shells, const std::vector<std::uint8_t>& reversed,
                 const Execution& execution) {
  const auto is_reversed = [&](std::size_t t) { return reversed[shells.of_triangle[t]] != 0; };
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    if (!is_reversed(t)) return;
    surface.flip(TriangleId{t});
    // The half-edges ab, bc, ca became ac, cb, ba, so the first and the last swap places.
    std::swap(surface.twin[3 * t], surface.twin[3 * t + 2]);
  });
  for_each_polled(execution, surface.twin.size(), [&](std::size_t h) {
    HalfEdge& twin = surface.twin[h];
    if (is_reversed(twin / 3) && twin % 3 != 1) twin = twin - twin % 3 + (2 - twin % 3);
  });
}

namespace {

/// The new position of each triangle; kNoTriangle for triangles of dropped shells. Empty if the order does
/// not change.
struct Order {
  std::vector<TriangleId> place_of;
  std::uint32_t kept = 0;
};

Order final_order(const Shells& shells, const std::vector<std::uint32_t>& part_of_shell, std::size_t parts,
                  const Execution& execution) {
  const std::size_t count = shells.of_triangle.size();
  if (parts == 1 && std::find(part_of_shell.begin(), part_of_shell.end(), kNoIndex) == part_of_shell.end())
    return {};
  std::vector<std::uint32_t> start = filled<std::uint32_t>(execution, parts + 1, 0);
  for_each_polled(execution, count, [&](std::size_t t) {
    if (const std::uint32_t part = part_of_shell[shells.of_triangle[t]]; part != kNoIndex) ++start[part + 1];
  });
  for (std::size_t p = 1; p < start.size(); ++p) start[p] += start[p - 1];
  Order order{filled(execution, count, kNoTriangle), start.back()};
  for_each_polled(execution, count, [&](std::size_t t) {
    if (const std::uint32_t part = part_of_shell[shells.of_triangle[t]]; part != kNoIndex)
      order.place_of[t] = TriangleId{start[part]++};
  });
  return order;
}

}  // namespace

void group_by_part(Surface& surface, Shells& shells, const std::vector<std::uint32_t>& part_of_shell,
                   std::size_t parts, const Execution& execution) {
  const Order order = final_order(shells, part_of_shell, parts, execution);
  if (order.place_of.empty()) return;
  Surface moved;
  moved.triangles = filled(execution, order.kept, Triangle{});
  moved.source = filled<std::uint32_t>(execution, order.kept, 0);
  moved.twin.of_triangle = filled(execution, order.kept, kThreeOpen);
  if (!surface.flipped.empty()) moved.flipped = filled<std::uint8_t>(execution, order.kept, 0);
  std::vector<std::uint32_t> shell = filled<std::uint32_t>(execution, order.kept, 0);
  for_each_polled(execution, order.place_of.size(), [&](std::size_t t) {
    const TriangleId to = order.place_of[t];
    if (to == kNoTriangle) return;
    moved.triangles[to] = surface.triangles[t];
    moved.source[to] = surface.source[t];
    shell[to] = shells.of_triangle[t];
    if (!surface.flipped.empty()) moved.flipped[to] = surface.flipped[t];
    for (HalfEdge k = 0; k < 3; ++k) {  // glued triangles belong to one shell, so the twin was kept too
      const HalfEdge twin = surface.twin[3 * t + k];
      moved.twin[3 * to + k] = 3 * order.place_of[twin / 3] + twin % 3;
    }
  });
  surface.triangles = std::move(moved.triangles);
  execution.poll();
  surface.source = std::move(moved.source);
  surface.twin = std::move(moved.twin);
  execution.poll();
  surface.flipped = std::move(moved.flipped);
  shells.of_triangle = std::move(shell);
}

void drop_unused_vertices(Surface& surface, const Execution& execution) {
  std::vector<VertexId> new_vertex = filled(execution, surface.positions.size(), kNoVertex);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    for (const VertexId v : surface.triangles[t]) new_vertex[v] = VertexId{0};
  });
  VertexId kept{0};
  for_each_polled(execution, new_vertex.size(), [&](std::size_t v) {
    if (new_vertex[v] == kNoVertex) return;
    new_vertex[v] = kept;
    surface.positions[kept++] = surface.positions[v];
  });
  surface.positions.resize(kept);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    for (VertexId& v : surface.triangles[t]) v = new_vertex[v];
  });
}

namespace {

/// Number of triangles whose entries are created at once. They are written while the zeroed memory is still
/// in the cache.
constexpr std::size_t kEntriesAtOnce = 16384;

/// Extends the arrays to one entry per triangle, and calls body(t) when the entries of t exist.
template <class Body, class... Arrays>
void fill_by_triangle(std::size_t count, const Execution& execution, const Body& body, Arrays&... arrays) {
  (arrays.reserve(count), ...);
  for (std::size_t begin = 0; begin < count; begin += kEntriesAtOnce) {
    execution.poll();
    const std::size_t end = std::min(count, begin + kEntriesAtOnce);
    (arrays.resize(end), ...);
    for (std::size_t t = begin; t < end; ++t) body(t);
  }
}

/// Replaces twins by edge numbers in place. A twin with a higher index still holds a half-edge; one with a
/// lower index already holds its edge number.
void number_edges(Surface& surface, Solid& solid, const Execution& execution) {
  solid.edge_vertices.reserve(surface.twin.size() / 2);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const Triangle& corners = surface.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      HalfEdge& number = surface.twin.of_triangle[t][k];
      if (number < 3 * t + k) {
        number = surface.twin[number];
        continue;
      }
      const VertexId a = corners[k], b = corners[k == 2 ? 0 : k + 1];
      number = static_cast<std::uint32_t>(solid.edge_vertices.size());
      solid.edge_vertices.push_back({std::min(a, b), std::max(a, b)});
    }
  });
  solid.edges = std::move(surface.twin.of_triangle);
}

void copy_source(const Mesh& mesh, const Surface& surface, Solid& solid, const Execution& execution) {
  fill_by_triangle(
      surface.triangles.size(), execution,
      [&](std::size_t t) {
        const std::uint32_t source = surface.source[t];
        if (source == kNoIndex) {
          solid.wedges[t] = {kNoIndex, kNoIndex, kNoIndex};
          solid.material[t] = kInteriorMaterial;
          return;
        }
        solid.wedges[t] = mesh.triangles[source];
        if (!surface.flipped.empty() && surface.flipped[t]) std::swap(solid.wedges[t][1], solid.wedges[t][2]);
        solid.material[t] = source < mesh.material.size() ? mesh.material[source] : kNoIndex;
      },
      solid.wedges, solid.material);
}

void write_parts(const std::vector<std::uint32_t>& part_of_shell, const std::vector<std::uint32_t>& new_shell,
                 Shells& shells, Solid& solid, const Execution& execution) {
  fill_by_triangle(
      shells.of_triangle.size(), execution,
      [&](std::size_t t) {
        solid.part[t] = part_of_shell[shells.of_triangle[t]];
        shells.of_triangle[t] = new_shell[shells.of_triangle[t]];
      },
      solid.part);
  solid.shell = std::move(shells.of_triangle);
}

}  // namespace

void write_out(const Mesh& mesh, Surface& surface, Shells& shells,
               const std::vector<std::uint32_t>& part_of_shell, const std::vector<std::uint32_t>& new_shell,
               Solid& solid, const Execution& execution) {
  // The longest task comes first. All of them mostly wait for memory from the system.
  side_by_side(
      execution, surface.triangles.size(), [&] { number_edges(surface, solid, execution); },
      [&] { copy_source(mesh, surface, solid, execution); },
      [&] { write_parts(part_of_shell, new_shell, shells, solid, execution); });
  solid.positions = std::move(surface.positions);
  solid.triangles = std::move(surface.triangles);
}

}  // namespace fracture::solid_detail
