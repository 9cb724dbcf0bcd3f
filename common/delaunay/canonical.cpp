// A numbering that depends on nothing but the set of tetrahedra and the site ids.
#include <algorithm>
#include <utility>

#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {
namespace {

// The permutation that sorts v, up to a last swap that keeps it even: a positive tetrahedron stays positive.
std::array<std::uint8_t, 4> canonical_order(const std::array<SiteId, 4>& v) {
  std::array<std::uint8_t, 4> order{0, 1, 2, 3};
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
  return order;
}

}  // namespace

void canonicalize(Tetrahedralization& t) {
  for (Tetrahedron& tet : t.tets) {
    const std::array<std::uint8_t, 4> order = canonical_order(tet.v);
    const Tetrahedron old = tet;
    for (int k = 0; k < 4; ++k) {
      tet.v[k] = old.v[order[k]];
      tet.n[k] = old.n[order[k]];
    }
  }
  // Two tetrahedra may share three vertices but never four, so comparing the tuples is a total order.
  std::vector<TetId> order(t.tets.size());
  for (TetId i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](TetId a, TetId b) { return t.tets[a].v < t.tets[b].v; });
  std::vector<TetId> new_id(order.size());
  for (TetId i = 0; i < order.size(); ++i) new_id[order[i]] = i;
  std::vector<Tetrahedron> tets(t.tets.size());
  std::fill(t.tet_of_site.begin(), t.tet_of_site.end(), kNoTet);
  for (TetId i = 0; i < order.size(); ++i) {
    tets[i] = t.tets[order[i]];
    for (TetId& n : tets[i].n)
      if (n != kNoTet) n = new_id[n];
    for (const SiteId s : tets[i].v)
      if (t.tet_of_site[s] == kNoTet) t.tet_of_site[s] = i;
  }
  t.tets = std::move(tets);
}

}  // namespace fracture
