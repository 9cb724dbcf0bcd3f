#include "common/solid/holes.hpp"

#include <algorithm>
#include <span>

#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/mesh/loop_triangulation.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/seams.hpp"

namespace fracture::solid_detail {

HalfEdge next_along_hole(const Surface& surface, HalfEdge h, Pacer& pacer) {
  HalfEdge p = previous(h);
  while (surface.twin[p] != kNoIndex) {
    pacer.step();
    p = previous(surface.twin[p]);
  }
  return p;
}

namespace {

/// Appends the triangles (indices into the loop), and glues them to the loop's half-edges and to each other.
void glue_in(Surface& surface, const std::vector<HalfEdge>& loop, const std::vector<LoopTriangle>& fill,
             const Execution& execution) {
  // Corner i of the loop is the vertex from which the walk follows loop[i]: the end of that half-edge.
  const auto count = static_cast<std::uint32_t>(loop.size());
  struct Side {
    std::uint64_t key;  // lower corner << 32 | higher corner
    HalfEdge half_edge;
  };
  std::vector<Side> diagonals;
  Pacer pacer(execution);
  for (const LoopTriangle& t : fill) {
    pacer.step();
    const auto first = static_cast<HalfEdge>(3 * surface.triangles.size());
    surface.triangles.push_back({surface.to(loop[t[0]]), surface.to(loop[t[1]]), surface.to(loop[t[2]])});
    surface.source.push_back(kNoIndex);
    if (!surface.flipped.empty()) surface.flipped.push_back(0);
    surface.twin.of_triangle.push_back(kThreeOpen);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t i = t[k], j = t[(k + 1) % 3];
      if (j == (i + 1 == count ? 0 : i + 1)) {
        surface.twin[first + k] = loop[i];
        surface.twin[loop[i]] = first + k;
      } else {
        const std::uint64_t low = std::min(i, j), high = std::max(i, j);
        diagonals.push_back({low << 32 | high, first + k});
      }
    }
  }
  sort_with_polls(execution, diagonals.begin(), diagonals.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.half_edge < b.half_edge;
  });
  for (std::size_t i = 0; i + 1 < diagonals.size(); i += 2) {
    pacer.step();
    if (diagonals[i].key != diagonals[i + 1].key)
      throw InternalError("hole filling: a diagonal has one side");
    surface.twin[diagonals[i].half_edge] = diagonals[i + 1].half_edge;
    surface.twin[diagonals[i + 1].half_edge] = diagonals[i].half_edge;
  }
}

/// Reserves memory for the fills. A hole needs fewer triangles than it has sides.
void grow_for_fills(Surface& surface, const Execution& execution) {
  std::size_t open = 0;
  for_each_polled(execution, surface.twin.size(),
                  [&](std::size_t h) { open += surface.twin[h] == kNoIndex; });
  make_room(execution, surface.triangles, open);
  make_room(execution, surface.source, open);
  if (!surface.flipped.empty()) make_room(execution, surface.flipped, open);
  make_room(execution, surface.twin.of_triangle, open);
}

}  // namespace

std::vector<TriangleId> fill_holes(Surface& surface, double tolerance, const Execution& execution) {
  std::vector<TriangleId> fills;
  const auto half_edges = static_cast<HalfEdge>(surface.twin.size());
  std::vector<HalfEdge> whole, walk, loop;
  std::vector<Vec3f> corners;
  grow_for_fills(surface, execution);
  // Index of each vertex in the walk.
  std::vector<std::uint32_t> place = filled(execution, surface.positions.size(), kNoIndex);
  Pacer pacer(execution);

  const auto fill = [&](std::span<const HalfEdge> simple) {
    loop.assign(simple.begin(), simple.end());
    if (loop.size() == 2) {  // a slit: its two sides become one edge
      surface.twin[loop[0]] = loop[1];
      surface.twin[loop[1]] = loop[0];
      return;
    }
    execution.made(Product::kSurfaceTriangles, loop.size() - 2);
    corners.clear();
    for (const HalfEdge side : loop) {
      pacer.step();
      corners.push_back(surface.positions[surface.to(side)]);
    }
    fills.push_back(TriangleId{surface.triangles.size()});
    pacer.step(loop.size() <= kSmallLoop ? loop.size() * loop.size() : 1);
    glue_in(surface, loop, triangulate_loop(corners, execution), execution);
  };

  for (const std::vector<HalfEdge>& seam : find_seams(surface, tolerance, execution)) fill(seam);
  std::vector<std::uint8_t> walked = filled<std::uint8_t>(execution, half_edges, 0);
  for (HalfEdge start = 0; start < half_edges; ++start) {
    pacer.step();
    if (surface.twin[start] != kNoIndex || walked[start]) continue;
    // Collect the whole loop first, because gluing changes the result of next_along_hole().
    whole.clear();
    for (HalfEdge h = start; !walked[h]; h = next_along_hole(surface, h, pacer)) {
      pacer.step();
      walked[h] = 1;
      whole.push_back(h);
    }
    walk.clear();
    for (const HalfEdge h : whole) {
      pacer.step(2);
      const VertexId v = surface.to(h);
      if (place[v] != kNoIndex) {  // back at a vertex: the walk since then is a loop by itself
        const std::size_t begin = place[v];
        for (std::size_t i = begin; i < walk.size(); ++i) place[surface.to(walk[i])] = kNoIndex;
        fill(std::span(walk).subspan(begin));
        walk.resize(begin);
      }
      place[v] = static_cast<std::uint32_t>(walk.size());
      walk.push_back(h);
    }
    for (const HalfEdge h : walk) place[surface.to(h)] = kNoIndex;
    fill(walk);
  }
  return fills;
}

}  // namespace fracture::solid_detail
