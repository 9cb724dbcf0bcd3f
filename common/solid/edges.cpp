#include "common/solid/edges.hpp"

#include <algorithm>

#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

EdgeTable::EdgeTable(const Surface& surface, const Execution& execution)
    : start_(filled<std::uint32_t>(execution, surface.positions.size() + 2, 0)),
      uses_(filled(execution, 3 * surface.triangles.size(), EdgeUse{0})) {
  // start_ is shifted by one while scattering, so that it ends as the table of beginnings.
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

bool pair_closed_manifold(Surface& surface, const Execution& execution) {
  struct Edge {
    VertexId high;
    std::uint32_t next;   // the next edge of the same lower vertex
    std::uint32_t first;  // half-edge << 1 | backward of the first use; kNoIndex once the second is there
  };
  const std::size_t half_edges = 3 * surface.triangles.size();
  std::vector<std::uint32_t> edge_of =
      filled(execution, surface.positions.size(), kNoIndex);  // by lower vertex
  std::vector<Edge> edges;
  edges.reserve(half_edges / 2);
  surface.twin = filled<HalfEdge>(execution, half_edges, 0);
  // A vertex with very many edges is left to the sorted table.
  std::size_t steps_left = 16 * half_edges + 1024, open = 0;
  HalfEdge h = 0;
  Pacer pacer(execution);
  for (const Triangle& t : surface.triangles) {
    pacer.step();
    for (int k = 0; k < 3; ++k, ++h) {
      const VertexId u = t[k], v = t[k == 2 ? 0 : k + 1];
      const VertexId low = std::min(u, v), high = std::max(u, v);
      const std::uint32_t use = h << 1 | (u > v ? 1u : 0u);
      std::uint32_t e = edge_of[low];
      while (e != kNoIndex && edges[e].high != high) {
        e = edges[e].next;
        if (--steps_left == 0) return false;
        pacer.step();
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
  }
  return open == 0;
}

bool pair_clean_edges(Surface& surface, const EdgeTable& edges, const Execution& execution) {
  surface.twin = filled(execution, 3 * surface.triangles.size(), kNoIndex);
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
