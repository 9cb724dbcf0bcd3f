#include "common/clip/caps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/base/work_blocks.hpp"
#include "common/clip/facet_segments.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {
namespace {

/// Builds the caps of one facet after another; keeps its buffers in between.
class FacetBuilder {
 public:
  FacetBuilder(const VoronoiDiagram& diagram, const VertexPositions& positions, const Execution& execution,
               Caps& out)
      : diagram_(diagram), positions_(positions), execution_(execution), pacer_(execution), out_(out) {}

  /// segments: all segments of one facet, in the order in which they were gathered.
  void build(const CapSegment* first, const CapSegment* last) {
    chain(first, last);
    count_triangles();
    project(first->lo, first->hi);
    triangulate(points_, loop_begin_, triangulation_, execution_);
    out_.crossing += triangulation_.unnested_loops;
    add_regions(*first);
  }
  /// Reports the triangles added since the last call. build() reports many at a time.
  void count_all_triangles() {
    execution_.made(Product::kCapTriangles, uncounted_);
    uncounted_ = 0;
  }

 private:
  // Stores the facet's triangles grouped by region, keeping their order (counting sort).
  void add_regions(const CapSegment& facet) {
    const auto& t = triangulation_;
    const auto base = static_cast<std::uint32_t>(out_.triangles.size());
    const auto corners = [&](std::size_t k) {
      const auto& v = t.triangles[k];
      return std::array<CutVertexId, 3>{loop_[v[0]], loop_[v[1]], loop_[v[2]]};
    };
    if (t.regions == 1) {  // the usual case
      pacer_.each(0, t.triangles.size(), [&](std::size_t k) { out_.triangles.push_back(corners(k)); });
      if (!t.triangles.empty())
        out_.regions.push_back(
            {facet.lo, facet.hi, facet.part, base, static_cast<std::uint32_t>(t.triangles.size())});
      return;
    }
    region_begin_.assign(t.regions + 1, 0);
    for (const std::uint32_t r : t.region) ++region_begin_[r + 1];
    for (std::uint32_t r = 0; r < t.regions; ++r) {
      region_begin_[r + 1] += region_begin_[r];
      const std::uint32_t count = region_begin_[r + 1] - region_begin_[r];
      if (count > 0) out_.regions.push_back({facet.lo, facet.hi, facet.part, base + region_begin_[r], count});
    }
    out_.triangles.resize(base + t.triangles.size());
    pacer_.each(0, t.triangles.size(),
                [&](std::size_t k) { out_.triangles[base + region_begin_[t.region[k]]++] = corners(k); });
  }

  // Counts about as many triangles as the loops have points, before they are made.
  void count_triangles() {
    uncounted_ += loop_.size();
    if (uncounted_ >= kCountedTogether) count_all_triangles();
  }

  // Chains directed pieces into loops. As many pieces leave a vertex as arrive at it. There is more than one
  // of each only if the winding number is above one; then the k-th copy that arrives continues with the k-th
  // that leaves.
  void chain(const CapSegment* first, const CapSegment* last) {
    edges_.clear();
    std::uint64_t copies = 0;
    for (const CapSegment* s = first; s != last; ++s)
      copies += static_cast<std::uint64_t>(std::abs(static_cast<std::int64_t>(s->multiplicity)));
    const auto segments = static_cast<std::uint64_t>(last - first);
    if (copies > segments) execution_.made(Product::kSegments, copies - segments);
    pacer_.each(0, segments, [&](std::size_t n) {
      const CapSegment& s = first[n];
      for (std::int32_t copy = 0; copy < std::abs(s.multiplicity); ++copy)
        edges_.push_back(s.multiplicity > 0 ? Edge{s.from, s.to} : Edge{s.to, s.from});
    });
    // From last to first, so that each vertex's list is ascending.
    leaving_.next_epoch(positions_.steps.size());
    pacer_.each(0, edges_.size(), [&](std::size_t n) {
      const auto e = static_cast<std::uint32_t>(edges_.size() - 1 - n);
      std::uint32_t& first_leaving = leaving_.slot(edges_[e].from - positions_.first_constructed);
      edges_[e].other = first_leaving;
      first_leaving = e;
    });
    loop_.clear();
    loop_begin_.assign(1, 0);
    for (std::uint32_t start = 0; start < edges_.size(); ++start) {
      if (edges_[start].used) continue;
      const CutVertexId home = edges_[start].from;
      for (std::uint32_t e = start;;) {
        edges_[e].used = true;
        loop_.push_back(edges_[e].from);
        const CutVertexId at = edges_[e].to;
        if (at == home) break;
        e = next_from(at, first);
      }
      pacer_.step(loop_.size() - loop_begin_.back());
      loop_begin_.push_back(static_cast<std::uint32_t>(loop_.size()));
    }
  }

  std::uint32_t next_from(CutVertexId v, const CapSegment* facet) {
    // Used edges never become unused, so they are removed from the vertex's list.
    std::uint32_t& first = leaving_.slot(v - positions_.first_constructed);
    while (first != kNoIndex && edges_[first].used) first = edges_[first].other;
    if (first != kNoIndex) return first;
    throw InternalError("cap of cells " + std::to_string(facet->lo) + " and " + std::to_string(facet->hi) +
                        " is open at vertex " + std::to_string(v));
  }

  // Projects the loops along the axis in which the bisector's normal is longest, keeping the orientation seen
  // from cell hi.
  void project(SiteId lo, SiteId hi) {
    const Vec3d u = diagram_.facet_normal(lo, hi);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::fabs(u[a]) > std::fabs(u[axis])) axis = a;
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (u[axis] < 0) std::swap(x, y);
    points_.resize(loop_.size());
    pacer_.each(0, loop_.size(), [&](std::size_t k) {
      const auto& s = positions_.steps[loop_[k] - positions_.first_constructed];
      points_[k] = {s[static_cast<std::size_t>(x)], s[static_cast<std::size_t>(y)]};
    });
  }

  struct Edge {
    CutVertexId from, to;
    bool used = false;
    std::uint32_t other = kNoIndex;  // the next edge that leaves `from`
  };
  const VoronoiDiagram& diagram_;
  const VertexPositions& positions_;
  const Execution& execution_;
  Pacer pacer_;
  Caps& out_;
  static constexpr std::uint64_t kCountedTogether = 4096;
  std::uint64_t uncounted_ = 0;  // triangles
  std::vector<Edge> edges_;
  StampedMap& leaving_ = worker_map();  // vertex -> the first edge that leaves it
  std::vector<CutVertexId> loop_;
  std::vector<std::uint32_t> loop_begin_;
  std::vector<LatticePoint> points_;
  Triangulation triangulation_;
  std::vector<std::uint32_t> region_begin_;
};

/// The source of a face has 31 bits for the two sides of a region.
constexpr std::size_t kMostRegions = std::size_t{1} << 30;

}  // namespace

Caps build_caps(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const Winding& winding, const VertexPositions& positions, const Execution& execution,
                const std::vector<char>* wanted) {
  const FacetSegments segments = gather_segments(solid, diagram, cuts, winding, execution, wanted);
  const std::vector<std::uint32_t>& facet_begin = segments.begin;
  const std::size_t facets = facet_begin.size() - 1;
  const WorkBlocks blocks(execution, facets, 200'000, [&](std::size_t f) {
    return 200 + 100 * static_cast<std::uint64_t>(facet_begin[f + 1] - facet_begin[f]);
  });
  std::vector<Caps> found(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    FacetBuilder builder(diagram, positions, execution, found[block]);
    for (std::size_t f = begin; f < end; ++f)
      builder.build(segments.all.data() + facet_begin[f], segments.all.data() + facet_begin[f + 1]);
    builder.count_all_triangles();
  });

  Pacer pacer(execution);
  Caps out;
  std::size_t regions = 0, triangles = 0;
  for (const Caps& block : found) {
    regions += block.regions.size();
    triangles += block.triangles.size();
  }
  if (regions >= kMostRegions || triangles >= 0xffffffffu)
    throw Interrupted(
        Error{ErrorCode::kTooComplex, "The cuts have more than 2^30 pieces. Ask for fewer sites."});
  out.regions.reserve(regions);
  out.triangles.reserve(triangles);
  for (Caps& block : found) {
    pacer.step(block.regions.size() + block.triangles.size());
    const auto base = static_cast<std::uint32_t>(out.triangles.size());
    for (CapRegion r : block.regions) {
      r.first_triangle += base;
      out.regions.push_back(r);
    }
    out.triangles.insert(out.triangles.end(), block.triangles.begin(), block.triangles.end());
    out.crossing += block.crossing;
    block = {};
  }
  begin_at_coinciding_corners(positions, out, execution);
  return out;
}

void begin_at_coinciding_corners(const VertexPositions& positions, Caps& caps, const Execution& execution) {
  const auto at = [&](CutVertexId v) -> const auto& {
    return positions.steps[v - positions.first_constructed];
  };
  parallel_for(execution, caps.triangles.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      if (auto& t = caps.triangles[k]; at(t[1]) == at(t[2])) t = {t[1], t[2], t[0]};
  });
}

}  // namespace fracture
