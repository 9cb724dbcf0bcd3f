#include "common/clip/surface_cuts.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "common/base/work_blocks.hpp"
#include "common/clip/cell_filter.hpp"
#include "common/clip/edge_walk.hpp"
#include "common/clip/polygon_clipper.hpp"

namespace fracture {
namespace {

constexpr std::size_t kBlock = 1024;  // vertices or edges per block of parallel work

/// Minimum number of mesh vertices per site at which the filter is worth its cost.
constexpr std::size_t kVerticesForFilter = 8;

/// Vertex ids below this leave the bit kBlockLocalC free.
constexpr std::size_t kMostCorners = kBlockLocalC;

std::vector<SiteId> label_vertices(const Solid& solid, const VoronoiDiagram& diagram,
                                   const Execution& execution) {
  const std::size_t n = solid.positions.size();
  // Any neighbour with a lower id is a good start for the walk.
  std::vector<std::uint32_t> hint(n, kNoIndex);
  Pacer pacer(execution);
  pacer.each(0, solid.edge_vertices.size(), [&](std::size_t e) {
    const auto& [lo, hi] = solid.edge_vertices[e];
    hint[hi] = lo;
  });
  std::optional<CellFilter> filter;  // building it takes as long as labelling three vertices per site
  if (n > kVerticesForFilter * diagram.dual().site_count()) filter.emplace(diagram, solid.box, execution);
  std::vector<SiteId> label(n);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    Pacer own_pacer(execution);
    VoronoiDiagram::Walk walk;
    SiteId last{0};
    for (std::size_t v = begin; v < end; ++v) {
      const SiteId start = hint[v] != kNoIndex && hint[v] >= begin ? label[hint[v]] : last;
      const std::uint64_t before = walk.looked_at;
      const Vec3d at = to_double(solid.positions[v]);
      last = label[v] = filter && filter->surely_holds(start, at) ? start : diagram.nearest(at, start, walk);
      own_pacer.step(1 + walk.looked_at - before);
    }
  });
  return label;
}

void cut_edges(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution,
               SurfaceCuts& out) {
  const std::size_t n = solid.edge_vertices.size(), blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<EdgeCut>> found(blocks);
  parallel_for(execution, n, kBlock, [&](std::size_t begin, std::size_t end) {
    EdgeWalk walk(solid, diagram, out.label, execution);
    Pacer own_pacer(execution);
    own_pacer.each(begin, end, [&](std::size_t e) {
      const auto& [lo, hi] = solid.edge_vertices[e];
      if (out.label[lo] != out.label[hi]) walk.cut(static_cast<std::uint32_t>(e), found[begin / kBlock]);
    });
  });
  Pacer pacer(execution);
  for (const auto& cuts : found) {
    out.edge_cuts.insert(out.edge_cuts.end(), cuts.begin(), cuts.end());
    pacer.step(cuts.size());
  }
  out.edge_cut_begin.assign(n + 1, 0);
  pacer.each(0, out.edge_cuts.size(),
             [&](std::size_t c) { ++out.edge_cut_begin[out.edge_cuts[c].edge + 1]; });
  pacer.each(0, n, [&](std::size_t e) { out.edge_cut_begin[e + 1] += out.edge_cut_begin[e]; });
}

/// Joins the blocks. C ids were relative to each block's start.
void join(const Execution& execution, const std::vector<TriangleDivision>& found, SurfaceCuts& out) {
  struct Begin {
    std::size_t cuts = 0, polygons = 0, vertices = 0;
  };
  std::vector<Begin> begin(found.size() + 1);
  for (std::size_t b = 0; b < found.size(); ++b)
    begin[b + 1] = {begin[b].cuts + found[b].triangle_cuts.size(),
                    begin[b].polygons + found[b].polygons.size(),
                    begin[b].vertices + found[b].vertices.size()};
  const Begin& all = begin.back();
  if (all.vertices > kMostCorners || out.first_c() + all.cuts > kMostCorners)
    throw Interrupted(Error{ErrorCode::kTooComplex,
                            "The surface is cut into polygons with more than 2^31 corners "
                            "in all. Ask for fewer sites."});
  resize_with_polls(execution, out.triangle_cuts, all.cuts);
  resize_with_polls(execution, out.polygons, all.polygons);
  resize_with_polls(execution, out.vertices, all.vertices);
  resize_with_polls(execution, out.sides, all.vertices);
  const CutVertexId first_c = out.first_c();
  parallel_for(execution, found.size(), 1, [&](std::size_t first, std::size_t last) {
    Pacer pacer(execution);
    for (std::size_t b = first; b < last; ++b) {
      const TriangleDivision& block = found[b];
      const Begin& at = begin[b];
      const auto c_base = first_c + static_cast<std::uint32_t>(at.cuts);
      for (std::size_t k = 0; k < block.vertices.size(); ++k) {
        const CutVertexId v = block.vertices[k];
        out.vertices[at.vertices + k] = v & kBlockLocalC ? CutVertexId{c_base + (v & ~kBlockLocalC)} : v;
        out.sides[at.vertices + k] = block.sides[k];
        pacer.step();
      }
      for (std::size_t k = 0; k < block.polygons.size(); ++k) {
        out.polygons[at.polygons + k] = block.polygons[k];
        out.polygons[at.polygons + k].first += static_cast<std::uint32_t>(at.vertices);
        pacer.step();
      }
      std::copy(block.triangle_cuts.begin(), block.triangle_cuts.end(),
                out.triangle_cuts.begin() + static_cast<std::ptrdiff_t>(at.cuts));
      pacer.step(block.triangle_cuts.size());
    }
  });
}

void cut_triangles(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution,
                   SurfaceCuts& out) {
  std::vector<std::uint32_t> cut;
  Pacer pacer(execution);
  pacer.each(0, solid.triangles.size(), [&](std::size_t t) {
    const auto& v = solid.triangles[t];
    if (out.label[v[0]] != out.label[v[1]] || out.label[v[1]] != out.label[v[2]])
      cut.push_back(static_cast<std::uint32_t>(t));
  });
  // A large triangle whose edges have n cuts in total has about n²/24 polygons, and each takes some hundred
  // nanoseconds.
  const WorkBlocks blocks(execution, cut.size(), 400'000, [&](std::size_t k) {
    std::uint64_t n = 0;
    for (const std::uint32_t e : solid.edges[cut[k]]) n += out.edge_cut_begin[e + 1] - out.edge_cut_begin[e];
    return 100 + 100 * n + 40 * n * n;
  });
  std::vector<TriangleDivision> found(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    PolygonClipper clipper(solid, diagram, out, execution, found[block]);
    for (std::size_t k = begin; k < end; ++k) clipper.divide(cut[k]);
    clipper.count_polygons();
  });
  join(execution, found, out);
}

}  // namespace

SurfaceCuts cut_surface(const Solid& solid, const VoronoiDiagram& diagram, std::vector<SiteId> label,
                        const Execution& execution) {
  SurfaceCuts out;
  out.label = std::move(label);
  cut_edges(solid, diagram, execution, out);
  cut_triangles(solid, diagram, execution, out);
  return out;
}

SurfaceCuts cut_surface(const Solid& solid, const VoronoiDiagram& diagram, const Execution& execution) {
  return cut_surface(solid, diagram, label_vertices(solid, diagram, execution), execution);
}

}  // namespace fracture
