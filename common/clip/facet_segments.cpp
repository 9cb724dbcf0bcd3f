#include "common/clip/facet_segments.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/base/work_blocks.hpp"

namespace fracture {
namespace {

/// Sorts the segments of a cell by neighbour, if that alone identifies the facet. Avoids comparisons with
/// unpredictable branches: numbers the neighbours as they occur, ranks these few numbers, and counts.
class FewNeighbors {
 public:
  /// Sorts stably, and appends the index at which each facet begins, counted from `from`. Returns false and
  /// does nothing if the segments are in several parts or there are too many neighbours.
  bool sort(std::span<CapSegment> segments, std::size_t sites, std::uint32_t from,
            std::vector<std::uint32_t>& facets) {
    if (segments.empty()) return true;
    local_.next_epoch(sites);
    number_.resize(segments.size());
    count_.fill(0);
    std::uint32_t neighbors = 0;
    bool one_part = true;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const CapSegment& s = segments[k];
      const std::uint32_t n = local_.number(s.hi, neighbors);
      hi_[neighbors] = s.hi;
      neighbors += n == neighbors;
      one_part &= s.part == segments[0].part;
      if (neighbors > kMost) return false;
      number_[k] = n;
      ++count_[n];
    }
    if (!one_part) return false;
    for (std::uint32_t i = 0; i < neighbors; ++i) {
      std::uint32_t rank = 0, before = 0;  // before: segments of lower neighbours
      for (std::uint32_t j = 0; j < neighbors; ++j) {
        const bool less = hi_[j] < hi_[i];
        rank += less;
        before += less ? count_[j] : 0;
      }
      next_[i] = before;
      begin_[rank] = from + before;
    }
    facets.insert(facets.end(), begin_.begin(), begin_.begin() + neighbors);
    unsorted_.assign(segments.begin(), segments.end());
    for (std::size_t k = 0; k < segments.size(); ++k) segments[next_[number_[k]]++] = unsorted_[k];
    return true;
  }

 private:
  static constexpr std::uint32_t kMost = 64;

  StampedMap& local_ = worker_map();
  std::vector<std::uint32_t> number_;  // number of each segment's neighbour
  std::array<std::uint32_t, kMost + 1> hi_, count_, next_, begin_;
  std::vector<CapSegment> unsorted_;
};

}  // namespace

FacetSegments gather_segments(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const Winding& winding, const Execution& execution,
                              const std::vector<char>* wanted) {
  // Counting sort by lo, then a stable sort of each cell's few facets. Within a facet, segments stay in the
  // order in which they were gathered.
  const std::uint32_t sites = diagram.dual().site_count();
  std::vector<std::uint32_t> begin(sites + 1, 0);
  Pacer pacer(execution);
  // The surface: the cap of cell lo goes along the bisector in the opposite direction to lo's polygon. Which
  // sides belong to caps is unpredictable, so every side is written, and the next one overwrites it if it
  // belongs to none.
  const auto of_caps = [&](const CutPolygon& p, PolygonSide side) {
    const bool bisector = !is_mesh_edge(side), lower = side >= p.cell, is = bisector & lower;
    return wanted && is ? (*wanted)[p.cell] || (*wanted)[side] : is;
  };
  std::size_t of_surface = 0;
  for (const CutPolygon& p : cuts.polygons) {
    pacer.step(p.count);
    for (std::uint32_t k = 0; k < p.count; ++k) of_surface += of_caps(p, cuts.sides[p.first + k]);
  }
  const std::uint64_t all = of_surface + winding.segments.size();
  execution.made(Product::kSegments, of_surface);
  if (all >= 0xffffffffu)
    throw Interrupted(Error{ErrorCode::kTooComplex,
                            "The caps have more than 2^32 boundary segments. Ask for fewer sites."});
  std::vector<CapSegment> gathered;
  resize_with_polls(execution, gathered, of_surface + 1);
  of_surface = 0;
  for (const CutPolygon& p : cuts.polygons) {
    pacer.step(p.count);
    for (std::uint32_t k = 0; k < p.count; ++k) {
      const PolygonSide side = cuts.sides[p.first + k];
      const CutVertexId from = cuts.vertices[p.first + k],
                        to = cuts.vertices[p.first + (k + 1 < p.count ? k + 1 : 0)];
      gathered[of_surface] = {p.cell, SiteId{side}, to, from, 1, solid.part[p.triangle]};
      of_surface += of_caps(p, side);
    }
  }
  gathered.pop_back();
  const auto each = [&](const auto& visit) {
    for (const std::vector<CapSegment>* some : {&std::as_const(gathered), &winding.segments})
      pacer.each(0, some->size(), [&](std::size_t k) { visit((*some)[k]); });
  };
  each([&](const CapSegment& s) { ++begin[s.lo + 1]; });
  for (std::uint32_t s = 0; s < sites; ++s) begin[s + 1] += begin[s];
  std::vector<CapSegment> sorted;
  resize_with_polls(execution, sorted, all);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  each([&](const CapSegment& s) { sorted[next[s.lo]++] = s; });
  std::vector<CapSegment>().swap(gathered);
  const WorkBlocks blocks(execution, sites, 400'000,
                          [&](std::size_t s) { return 10 + 50 * (begin[s + 1] - begin[s]); });
  std::vector<std::vector<std::uint32_t>> facets(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t first, std::size_t last) {
    Pacer own_pacer(execution);
    struct Place {
      std::uint64_t facet;
      std::uint32_t from;
      auto operator<=>(const Place&) const = default;
    };
    std::vector<Place> order;
    std::vector<CapSegment> of_cell;
    FewNeighbors few;
    for (std::size_t s = first; s < last; ++s) {
      const std::uint32_t from = begin[s], count = begin[s + 1] - from;
      own_pacer.step(8 * count);
      if (few.sort({sorted.data() + from, count}, sites, from, facets[block])) continue;
      order.clear();
      for (std::uint32_t k = 0; k < count; ++k)
        order.push_back({static_cast<std::uint64_t>(sorted[from + k].hi) << 32 | sorted[from + k].part, k});
      sort_with_polls(execution, order.begin(), order.end());
      of_cell.assign(sorted.begin() + from, sorted.begin() + from + count);
      for (std::uint32_t k = 0; k < count; ++k) {
        sorted[from + k] = of_cell[order[k].from];
        if (k == 0 || order[k].facet != order[k - 1].facet) facets[block].push_back(from + k);
      }
    }
  });
  FacetSegments out{std::move(sorted), {}};
  for (const std::vector<std::uint32_t>& of_block : facets) {
    pacer.step(of_block.size());
    out.begin.insert(out.begin.end(), of_block.begin(), of_block.end());
  }
  out.begin.push_back(static_cast<std::uint32_t>(all));
  return out;
}

}  // namespace fracture
