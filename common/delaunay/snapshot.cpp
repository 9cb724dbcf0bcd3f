// From the mutable structure to the compact, canonical Tetrahedralization.
#include <algorithm>
#include <utility>

#include "common/delaunay/incremental.hpp"

namespace fracture {
namespace {

// The smallest vertex first, then the even arrangement of the other three with the second smallest second: a
// canonical name for a positive tetrahedron. `order` receives the permutation.
void canonical_order(const std::array<SiteId, 4>& v, std::array<std::uint8_t, 4>& order) {
  order = {0, 1, 2, 3};
  bool even = true;
  const auto compare_swap = [&](int i, int j) {
    if (v[order[j]] < v[order[i]]) {
      std::swap(order[i], order[j]);
      even = !even;
    }
  };
  compare_swap(0, 1);
  compare_swap(2, 3);
  compare_swap(0, 2);
  compare_swap(1, 3);
  compare_swap(1, 2);
  if (!even) std::swap(order[2], order[3]);
}

}  // namespace

Tetrahedralization IncrementalDelaunay::snapshot() const {
  std::vector<SiteId> site_of_vertex(vertices_.size(), kNoSite);
  SiteId next = 0;
  for (VertexId v = 4; v < vertices_.size(); ++v)
    if (is_live(v)) site_of_vertex[v] = next++;
  return snapshot(site_of_vertex);
}

Tetrahedralization IncrementalDelaunay::snapshot(std::span<const SiteId> site_of_vertex) const {
  const std::uint32_t sites = site_count();
  Tetrahedralization result;
  result.points.resize(sites + 4);
  std::vector<SiteId> name(vertices_.size(), kNoSite);
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    if (!is_live(v)) continue;
    name[v] = v < 4 ? sites + v : site_of_vertex[v];
    result.points[name[v]] = position(v);
  }

  // Order by sorted vertices: counted by the smallest one, then a small sort in each bucket.
  struct Entry {
    std::array<SiteId, 4> v;
    TetId tet;
    std::array<std::uint8_t, 4> order;
  };
  std::vector<std::uint32_t> start(sites + 6, 0);
  const auto least = [&](const Tet& t) {
    return std::min(std::min(name[t.v[0]], name[t.v[1]]), std::min(name[t.v[2]], name[t.v[3]]));
  };
  for (const Tet& t : tets_)
    if (t.v[0] != kNoVertex) ++start[least(t) + 1];
  for (std::size_t s = 1; s < start.size(); ++s) start[s] += start[s - 1];
  HugePageVector<Entry> entries(tet_count());
  {
    std::vector<std::uint32_t> cursor(start.begin(), start.end() - 1);
    for (TetId id = 0; id < tets_.size(); ++id) {
      const Tet& t = tets_[id];
      if (t.v[0] == kNoVertex) continue;
      const std::array<SiteId, 4> v{name[t.v[0]], name[t.v[1]], name[t.v[2]], name[t.v[3]]};
      Entry e;
      canonical_order(v, e.order);
      e.v = {v[e.order[0]], v[e.order[1]], v[e.order[2]], v[e.order[3]]};
      e.tet = id;
      entries[cursor[e.v[0]]++] = e;
    }
  }
  const auto less = [](const Entry& a, const Entry& b) {
    if (a.v[1] != b.v[1]) return a.v[1] < b.v[1];
    // Second smallest first; the last two may be swapped for orientation.
    const SiteId a2 = std::min(a.v[2], a.v[3]), b2 = std::min(b.v[2], b.v[3]);
    if (a2 != b2) return a2 < b2;
    return std::max(a.v[2], a.v[3]) < std::max(b.v[2], b.v[3]);
  };
  for (std::uint32_t s = 0; s < sites + 4; ++s)
    std::sort(entries.begin() + start[s], entries.begin() + start[s + 1], less);

  std::vector<TetId> new_id(tets_.size(), kNoTet);
  for (TetId i = 0; i < entries.size(); ++i) new_id[entries[i].tet] = i;
  result.tets.resize(entries.size());
  result.tet_of_site.assign(sites + 4, kNoTet);
  for (TetId i = 0; i < entries.size(); ++i) {
    const Entry& e = entries[i];
    const Tet& t = tets_[e.tet];
    Tetrahedron& out = result.tets[i];
    out.v = e.v;
    for (int k = 0; k < 4; ++k) {
      const Link link = t.n[e.order[k]];
      out.n[k] = link == kNoLink ? kNoTet : new_id[link >> 2];
      if (result.tet_of_site[out.v[k]] == kNoTet) result.tet_of_site[out.v[k]] = i;
    }
  }
  return result;
}

}  // namespace fracture
