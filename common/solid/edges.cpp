#include "common/solid/edges.hpp"

#include <algorithm>
#include <atomic>

#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

EdgeTable::EdgeTable(const Surface& surface, const Execution& execution)
    : start_(filled<std::uint32_t>(execution, surface.positions.size() + 2, 0)),
      uses_(filled(execution, 3 * surface.triangles.size(), EdgeUse{0})) {
  // start_ is shifted by one while scattering, so it ends up as the table of first positions.
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t i) {
    const Triangle& t = surface.triangles[i];
    for (int k = 0; k < 3; ++k) ++start_[std::min(t[k], t[k == 2 ? 0 : k + 1]) + 2];
  });
  for_each_polled(execution, start_.size() - 1, [&](std::size_t v) { start_[v + 1] += start_[v]; });
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t i) {
    const Triangle& t = surface.triangles[i];
    auto h = static_cast<HalfEdge>(3 * i);
    for (int k = 0; k < 3; ++k, ++h) {
      const VertexId u = t[k], v = t[k == 2 ? 0 : k + 1];
      const std::uint64_t high = std::max(u, v);
      uses_[start_[std::min(u, v) + 1]++] = {high << 32 | static_cast<std::uint64_t>(h) << 1 |
                                             (u > v ? 1u : 0u)};
    }
  });
  start_.pop_back();
  for_each_polled(execution, start_.size() - 1, [&](std::size_t v) {
    if (start_[v + 1] - start_[v] < 2) return;
    EdgeUse* const first = uses_.data() + start_[v];
    EdgeUse* const last = uses_.data() + start_[v + 1];
    if (last - first > 24) {
      sort_with_polls(execution, first, last,
                      [](const EdgeUse& a, const EdgeUse& b) { return a.bits < b.bits; });
      return;
    }
    for (EdgeUse* i = first + 1; i < last; ++i) {
      const EdgeUse use = *i;
      EdgeUse* j = i;
      for (; j > first && use.bits < (j - 1)->bits; --j) *j = *(j - 1);
      *j = use;
    }
  });
}

namespace {

/// Pairs the half-edges of the edges whose lower vertex is in a given range. Each such vertex has a chain of
/// the first uses of its edges, stored in `twin` itself. The twin of a first use holds kFirst, the next
/// half-edge in the chain and, once the second use is found, kPaired. The twin of a second use is the first
/// use.
class ChainedEdges {
 public:
  static constexpr std::uint32_t kFirst = 1u << 31, kPaired = 1u << 30, kEnd = kPaired - 1;

  /// `chains`: per vertex the last element of its chain, or kEnd if the chain is empty.
  ChainedEdges(Surface& surface, std::vector<HalfEdge>& chains) : surface_(surface), chains_(chains) {}

  /// Returns false if an edge of the range is not used exactly twice in opposite directions, or if a vertex
  /// has too many edges.
  bool pair(VertexId begin, VertexId end, const Execution& execution) {
    // Stop if a vertex has very many edges; the sorted table is then faster.
    std::size_t steps_left = 16 * surface_.twin.size() + 1024, open = 0;
    Pacer pacer(execution);
    HalfEdge h = 0;
    for (const Triangle& t : surface_.triangles) {
      pacer.step();
      for (int k = 0; k < 3; ++k, ++h) {
        const VertexId u = t[k], v = t[k == 2 ? 0 : k + 1];
        const VertexId low = std::min(u, v), high = std::max(u, v);
        if (low < begin || low >= end) continue;
        HalfEdge first = chains_[low];
        Ends use{};
        for (; first != kEnd; first = surface_.twin[first] & kEnd) {
          use = ends(first);
          if ((use.from == low ? use.to : use.from) == high) break;
          if (--steps_left == 0) return false;
          pacer.step();
        }
        if (first == kEnd) {
          surface_.twin[h] = kFirst | chains_[low];
          chains_[low] = h;
          ++open;
          continue;
        }
        if ((surface_.twin[first] & kPaired) != 0 || use.from == u) return false;
        surface_.twin[first] |= kPaired;
        surface_.twin[h] = first;
        --open;
      }
    }
    return open == 0;
  }

 private:
  struct Ends {
    VertexId from, to;
  };
  Ends ends(HalfEdge h) const {
    const std::uint32_t t = h / 3, k = h - 3 * t;
    const Triangle& corners = surface_.triangles[t];
    return {corners[k], corners[k == 2 ? 0 : k + 1]};
  }

  Surface& surface_;
  std::vector<HalfEdge>& chains_;
};

/// Each range of vertices requires one pass over all triangles.
constexpr std::size_t kMostRanges = 8, kRangeVertices = 16384;

}  // namespace

bool pair_closed_manifold(Surface& surface, const Execution& execution) {
  const std::size_t half_edges = 3 * surface.triangles.size(), vertices = surface.positions.size();
  if (half_edges >= ChainedEdges::kEnd) return false;
  std::vector<HalfEdge> chains = filled(execution, vertices, HalfEdge{ChainedEdges::kEnd});
  if (surface.twin.size() != half_edges)
    surface.twin.of_triangle = filled(execution, surface.triangles.size(), kThreeOpen);
  // Each edge belongs to one range, so ranges share only data that they read.
  const std::size_t ranges = std::min(
      {static_cast<std::size_t>(std::max(1, execution.threads)), kMostRanges, 1 + vertices / kRangeVertices});
  std::atomic<bool> paired{true};
  parallel_for(execution, ranges, 1, [&](std::size_t range, std::size_t) {
    const VertexId begin{range * vertices / ranges}, end{(range + 1) * vertices / ranges};
    if (!ChainedEdges(surface, chains).pair(begin, end, execution)) paired = false;
  });
  if (!paired) return false;
  // Another thread may set the twin of a first use while this thread reads it. Both values are safe, because
  // the twin of the second use is already set.
  parallel_for(execution, half_edges, 65536, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = begin; h < end; ++h) {
      const HalfEdge first = std::atomic_ref(surface.twin[h]).load(std::memory_order_relaxed);
      if ((first & ChainedEdges::kFirst) == 0)
        std::atomic_ref(surface.twin[first]).store(static_cast<HalfEdge>(h), std::memory_order_relaxed);
    }
  });
  return true;
}

bool pair_clean_edges(Surface& surface, const EdgeTable& edges, const Execution& execution) {
  surface.twin.of_triangle = filled(execution, surface.triangles.size(), kThreeOpen);
  bool all = true;
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() == 2 && uses[0].backward() != uses[1].backward()) {
      surface.twin[uses[0].half_edge()] = uses[1].half_edge();
      surface.twin[uses[1].half_edge()] = uses[0].half_edge();
    } else {
      all = false;
    }
  });
  return all;
}

}  // namespace fracture::solid_detail
