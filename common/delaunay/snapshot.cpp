// Copies the mutable structure to the compact Tetrahedralization.
#include "common/base/pacer.hpp"
#include "common/base/pages.hpp"
#include "common/delaunay/incremental.hpp"

namespace fracture {

Tetrahedralization IncrementalDelaunay::snapshot() const {
  std::vector<SiteId> site_of_vertex(vertices_.size(), kNoSite);
  SiteId next{0};
  for (const TetVertexId v : ids<TetVertexId>(4, vertices_.size()))
    if (is_live(v)) site_of_vertex[v] = next++;
  return snapshot(site_of_vertex);
}

Tetrahedralization IncrementalDelaunay::snapshot(std::span<const SiteId> site_of_vertex) const {
  return snapshot(site_of_vertex, [](TetId) {});
}

Tetrahedralization IncrementalDelaunay::take_snapshot(std::span<const SiteId> site_of_vertex) {
  // A compact tetrahedron takes half the memory, so the input can be released to make room for the output. If
  // there are few tetrahedra, the pages are kept for the next tetrahedralization, which would otherwise have
  // each page faulted in and cleared.
  if (tets_.size() < kManyTets) return snapshot(site_of_vertex);
  PagesBehind behind(tets_.data(), tets_.size() * sizeof(Tet));
  return snapshot(site_of_vertex, [&](TetId read) { behind.through(read * sizeof(Tet)); });
}

template <class AfterReading>
Tetrahedralization IncrementalDelaunay::snapshot(std::span<const SiteId> site_of_vertex,
                                                 const AfterReading& after_reading) const {
  const std::uint32_t sites = site_count();
  Pacer pacer(*options_.execution);
  Tetrahedralization result;
  result.points.resize(sites + 4);
  result.tet_of_site.resize(sites + 4);
  // Gaps in the storage are closed; the order is kept.
  std::vector<TetId> moved;
  if (!free_tets_.empty()) {
    moved.resize(tets_.size(), kNoTet);
    TetId next{0};
    for (const TetId t : ids<TetId>(tets_.size()))
      if (tets_[t].v[0] != kNoVertex) moved[t] = next++;
  }
  const auto new_id = [&](TetId t) { return moved.empty() ? t : moved[t]; };

  std::vector<SiteId> name(vertices_.size(), kNoSite);
  for (const TetVertexId v : ids<TetVertexId>(vertices_.size())) {
    if (!is_live(v)) continue;
    name[v] = v < 4 ? SiteId{sites + v} : site_of_vertex[v];
    result.points[name[v]] = position(v);
    result.tet_of_site[name[v]] = new_id(vertices_[v].tet);
  }
  result.tets.reserve(tet_count());
  for (const TetId read : ids<TetId>(tets_.size())) {
    pacer.step();
    after_reading(read);
    const Tet& t = tets_[read];
    if (t.v[0] == kNoVertex) continue;
    const auto neighbour = [&](int k) { return t.n[k] == kNoLink ? kNoTet : new_id(t.n[k].tet()); };
    result.tets.push_back({{name[t.v[0]], name[t.v[1]], name[t.v[2]], name[t.v[3]]},
                           {neighbour(0), neighbour(1), neighbour(2), neighbour(3)}});
  }
  return result;
}

}  // namespace fracture
