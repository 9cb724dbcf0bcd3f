#include "common/solid/edges.hpp"

#include <algorithm>

namespace fracture::solid_detail {

EdgeTable::EdgeTable(const Surface& surface, const Execution& execution)
    : start_(surface.positions.size() + 2, 0), uses_(3 * surface.triangles.size()) {
  execution.poll();
  // start_ is shifted by one while scattering, so that it ends as the table of beginnings.
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k) ++start_[std::min(t[k], t[k == 2 ? 0 : k + 1]) + 2];
  for (std::size_t v = 2; v < start_.size(); ++v) start_[v] += start_[v - 1];
  HalfEdge h = 0;
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k, ++h) {
      const VertexId u = t[k], v = t[k == 2 ? 0 : k + 1];
      const std::uint64_t high = std::max(u, v);
      uses_[start_[std::min(u, v) + 1]++] = {high << 32 | static_cast<std::uint64_t>(h) << 1 |
                                             (u > v ? 1u : 0u)};
    }
  start_.pop_back();
  execution.poll();
  for (std::size_t v = 0; v + 1 < start_.size(); ++v) {
    EdgeUse* const first = uses_.data() + start_[v];
    EdgeUse* const last = uses_.data() + start_[v + 1];
    if (last - first > 24) {
      std::sort(first, last, [](const EdgeUse& a, const EdgeUse& b) { return a.bits < b.bits; });
      continue;
    }
    for (EdgeUse* i = first + 1; i < last; ++i) {
      const EdgeUse use = *i;
      EdgeUse* j = i;
      for (; j > first && use.bits < (j - 1)->bits; --j) *j = *(j - 1);
      *j = use;
    }
  }
}

bool pair_closed_manifold(Surface& surface, const Execution& execution) {
  execution.poll();
  struct Edge {
    VertexId high;
    std::uint32_t next;   // the next edge of the same lower vertex
    std::uint32_t first;  // half-edge << 1 | backward of the first use; kNoIndex once the second is there
  };
  const std::size_t half_edges = 3 * surface.triangles.size();
  std::vector<std::uint32_t> edge_of(surface.positions.size(), kNoIndex);  // by lower vertex
  std::vector<Edge> edges;
  edges.reserve(half_edges / 2);
  surface.twin.resize(half_edges);
  // A vertex with very many edges is left to the sorted table.
  std::size_t steps_left = 16 * half_edges + 1024, open = 0;
  HalfEdge h = 0;
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k, ++h) {
      const VertexId u = t[k], v = t[k == 2 ? 0 : k + 1];
      const VertexId low = std::min(u, v), high = std::max(u, v);
      const std::uint32_t use = h << 1 | (u > v ? 1u : 0u);
      std::uint32_t e = edge_of[low];
      while (e != kNoIndex && edges[e].high != high) {
        e = edges[e].next;
        if (--steps_left == 0) return false;
      }
      if (e == kNoIndex) {
        if (2 * edges.size() == half_edges) return false;
        edges.push_back({high, edge_of[low], use});
        edge_of[low] = static_cast<std::uint32_t>(edges.size() - 1);
        ++open;
        continue;
      }
      const std::uint32_t first = edges[e].first;
      if (first == kNoIndex || ((first ^ use) & 1) == 0) return false;
      edges[e].first = kNoIndex;
      surface.twin[h] = first >> 1;
      surface.twin[first >> 1] = h;
      --open;
    }
  return open == 0;
}

bool pair_clean_edges(Surface& surface, const EdgeTable& edges) {
  surface.twin.assign(3 * surface.triangles.size(), kNoIndex);
  bool all = true;
  edges.for_each([&](VertexId, VertexId, std::span<const EdgeUse> uses) {
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
