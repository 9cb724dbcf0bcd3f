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

void cut_edges(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution,
               SurfaceCuts& out) {
  const std::size_t n = solid.edge_vertices.size(), blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<EdgeCut>> found(blocks);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    std::vector<EdgeCut>& cuts = found[begin / kBlock];
    for (std::size_t e = begin; e < end; ++e) {
      const auto [lo, hi] = solid.edge_vertices[e];
      if (out.label[lo] != out.label[hi])
        cut_edge(solid, diagram, out.label, static_cast<std::uint32_t>(e), cuts);
    }
  });
  for (const auto& cuts : found) out.edge_cuts.insert(out.edge_cuts.end(), cuts.begin(), cuts.end());
  out.edge_cut_begin.assign(n + 1, 0);
  for (const EdgeCut& c : out.edge_cuts) ++out.edge_cut_begin[c.edge + 1];
  for (std::size_t e = 0; e < n; ++e) out.edge_cut_begin[e + 1] += out.edge_cut_begin[e];
}

void cut_triangles(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution,
                   SurfaceCuts& out) {
  const std::size_t n = solid.triangles.size(), blocks = (n + kBlock - 1) / kBlock;
  std::vector<TriangleDivision> found(blocks);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    PolygonClipper clipper(solid, diagram, out, found[begin / kBlock]);
    for (std::size_t t = begin; t < end; ++t) {
      const auto& v = solid.triangles[t];
      if (out.label[v[0]] != out.label[v[1]] || out.label[v[1]] != out.label[v[2]])
        clipper.divide(static_cast<std::uint32_t>(t));
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
  cut_edges(solid, diagram, execution, out);
  cut_triangles(solid, diagram, execution, out);
  return out;
}

}  // namespace fracture
