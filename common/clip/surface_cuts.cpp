#include "common/clip/surface_cuts.hpp"

#include <algorithm>
#include <string>

#include "common/clip/polygon_clipper.hpp"
#include "common/exact/side.hpp"

namespace fracture {
namespace {

constexpr std::size_t kBlock = 2048;  // mesh elements per block of parallel work

std::vector<SiteId> label_vertices(const Solid& solid, const VoronoiDiagram& diagram,
                                   const Execution& execution) {
  const std::size_t n = solid.positions.size();
  // Any neighbour with a lower id is a good place to start the walk.
  std::vector<std::uint32_t> hint(n, kNoIndex);
  for (const auto& [lo, hi] : solid.edge_vertices) hint[hi] = lo;
  std::vector<SiteId> label(n);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    SiteId last = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const SiteId start = hint[v] != kNoIndex && hint[v] >= begin ? label[hint[v]] : last;
      last = label[v] = diagram.nearest(to_double(solid.positions[v]), start);
    }
  });
  return label;
}

// Walks along edge e from cell to cell and appends its cuts.
void cut_edge(const Solid& solid, const VoronoiDiagram& diagram, const std::vector<SiteId>& label,
              std::uint32_t e, std::vector<EdgeCut>& cuts) {
  const auto [lo, hi] = solid.edge_vertices[e];
  const Vec3d a = to_double(solid.positions[lo]), b = to_double(solid.positions[hi]);
  for (SiteId cell = label[lo]; cell != label[hi];) {
    // Of all bisectors that b lies beyond, the one crossed first: the crossing that is inside all the others.
    SiteId first = kNoSite;
    for (const Bisector& bisector : diagram.bisectors(cell)) {
      if (diagram.side(cell, bisector, b) > 0) continue;
      if (first == kNoSite ||
          exact::side2(diagram.site(cell), diagram.site(bisector.neighbor), a, b, diagram.site(first)) < 0)
        first = bisector.neighbor;
    }
    if (first == kNoSite || diagram.dual().is_corner(first))
      throw InternalError("edge " + std::to_string(e) + " does not leave cell " + std::to_string(cell));
    cuts.push_back({e, cell, first});
    cell = first;
  }
}

/// What of the mesh is cut: the elements numbered here, or all of them.
struct Elements {
  std::size_t count;
  const std::vector<std::uint32_t>* list = nullptr;  // ascending
  std::uint32_t operator[](std::size_t k) const { return list ? (*list)[k] : static_cast<std::uint32_t>(k); }
};

void cut_edges(const Solid& solid, const VoronoiDiagram& diagram, const Elements& edges,
               const Execution& execution, SurfaceCuts& out) {
  const std::size_t n = edges.count, blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<EdgeCut>> found(blocks);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    std::vector<EdgeCut>& cuts = found[begin / kBlock];
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t e = edges[k];
      const auto [lo, hi] = solid.edge_vertices[e];
      if (out.label[lo] != out.label[hi]) cut_edge(solid, diagram, out.label, e, cuts);
    }
  });
  for (const auto& cuts : found) out.edge_cuts.insert(out.edge_cuts.end(), cuts.begin(), cuts.end());
  const std::size_t all = solid.edge_vertices.size();
  out.edge_cut_begin.assign(all + 1, 0);
  for (const EdgeCut& c : out.edge_cuts) ++out.edge_cut_begin[c.edge + 1];
  for (std::size_t e = 0; e < all; ++e) out.edge_cut_begin[e + 1] += out.edge_cut_begin[e];
}

void cut_triangles(const Solid& solid, const VoronoiDiagram& diagram, const Elements& triangles,
                   const Execution& execution, SurfaceCuts& out) {
  const std::size_t n = triangles.count, blocks = (n + kBlock - 1) / kBlock;
  std::vector<TriangleDivision> found(blocks);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    PolygonClipper clipper(solid, diagram, out, found[begin / kBlock]);
    for (std::size_t k = begin; k < end; ++k) {
      const auto& v = solid.triangles[triangles[k]];
      if (out.label[v[0]] != out.label[v[1]] || out.label[v[1]] != out.label[v[2]])
        clipper.divide(triangles[k]);
    }
  });
  // C ids are counted from each block's start until here.
  const VertexId first_c = out.first_c();
  for (const TriangleDivision& block : found) {
    const auto c_base = first_c + static_cast<VertexId>(out.triangle_cuts.size());
    const auto corner_base = static_cast<std::uint32_t>(out.vertices.size());
    for (const VertexId v : block.vertices)
      out.vertices.push_back(v & kBlockLocalC ? c_base + (v & ~kBlockLocalC) : v);
    for (CutPolygon p : block.polygons) {
      p.first += corner_base;
      out.polygons.push_back(p);
    }
    out.sides.insert(out.sides.end(), block.sides.begin(), block.sides.end());
    out.triangle_cuts.insert(out.triangle_cuts.end(), block.triangle_cuts.begin(), block.triangle_cuts.end());
  }
}

}  // namespace

SurfaceCuts cut_surface(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution) {
  SurfaceCuts out;
  out.label = label_vertices(solid, diagram, execution);
  cut_edges(solid, diagram, {solid.edge_vertices.size()}, execution, out);
  cut_triangles(solid, diagram, {solid.triangles.size()}, execution, out);
  return out;
}

SurfaceLabels labels_of(const SurfaceCuts& cuts) {
  SurfaceLabels labels{cuts.label, {}};
  labels.shares.reserve(cuts.polygons.size());
  for (const CutPolygon& p : cuts.polygons) labels.shares.push_back({p.triangle, p.cell});
  return labels;
}

SurfaceCuts cut_surface_again(const Solid& solid, const VoronoiDiagram& diagram, SurfaceLabels& before,
                              const std::vector<char>& of_interest, const Execution& execution) {
  // Triangles that met such a cell, and all of their edges.
  std::vector<char> met(solid.triangles.size(), 0), edge(solid.edge_vertices.size(), 0);
  for (const CellShare& share : before.shares) met[share.triangle] |= of_interest[share.cell];
  std::vector<std::uint32_t> triangles, edges;
  for (std::uint32_t t = 0; t < met.size(); ++t) {
    for (const std::uint32_t v : solid.triangles[t]) met[t] |= of_interest[before.label[v]];
    if (!met[t]) continue;
    triangles.push_back(t);
    for (const std::uint32_t e : solid.edges[t]) edge[e] = 1;
  }
  for (std::uint32_t e = 0; e < edge.size(); ++e)
    if (edge[e]) edges.push_back(e);

  SurfaceCuts out;
  out.label = std::move(before.label);
  for (std::size_t v = 0; v < out.label.size(); ++v)
    if (of_interest[out.label[v]])
      out.label[v] = diagram.nearest(to_double(solid.positions[v]), out.label[v]);
  cut_edges(solid, diagram, {edges.size(), &edges}, execution, out);
  cut_triangles(solid, diagram, {triangles.size(), &triangles}, execution, out);

  before.label = out.label;
  std::vector<CellShare> shares;
  shares.reserve(before.shares.size() + out.polygons.size());
  std::size_t p = 0;
  const auto take_until = [&](std::uint32_t triangle) {
    for (; p < out.polygons.size() && out.polygons[p].triangle < triangle; ++p)
      shares.push_back({out.polygons[p].triangle, out.polygons[p].cell});
  };
  for (const CellShare& share : before.shares) {
    if (met[share.triangle]) continue;
    take_until(share.triangle);
    shares.push_back(share);
  }
  take_until(static_cast<std::uint32_t>(met.size()));
  before.shares = std::move(shares);
  out.selection = std::move(triangles);
  return out;
}

}  // namespace fracture
