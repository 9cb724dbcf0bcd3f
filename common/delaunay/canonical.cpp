// A numbering that depends only on the set of tetrahedra and the site ids.
#include <algorithm>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {
namespace {

// The permutation that sorts v, with a final swap if needed to keep it even, so that a positive tetrahedron
// stays positive.
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

std::vector<TetId> canonicalize(Tetrahedralization& t, const Execution& execution) {
  // Two tetrahedra may share three vertices but never four, so comparing the tuples is a total order. Sorts
  // by the lowest site (counting sort), then the few of each site by the rest of the tuple.
  struct Entry {
    std::array<SiteId, 3> rest;
    TetId tet;
  };
  const std::size_t count = t.tets.size();
  Pacer pacer(execution);
  std::vector<std::uint32_t> begin(t.points.size() + 1, 0);
  for (Tetrahedron& tet : t.tets) {
    pacer.step();
    const std::array<std::uint8_t, 4> order = canonical_order(tet.v);
    const Tetrahedron old = tet;
    for (int k = 0; k < 4; ++k) {
      tet.v[k] = old.v[order[k]];
      tet.n[k] = old.n[order[k]];
    }
    ++begin[tet.v[0] + 1];
  }
  for (std::size_t s = 0; s < t.points.size(); ++s) begin[s + 1] += begin[s];
  std::vector<Entry> entries;
  resize_with_polls(execution, entries, count);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const TetId i : ids<TetId>(count)) {
    pacer.step();
    const auto& v = t.tets[i].v;
    entries[next[v[0]]++] = {{v[1], v[2], v[3]}, i};
  }
  std::vector<TetId> new_id(count);
  parallel_for(execution, t.points.size(), 64, [&](std::size_t first, std::size_t last) {
    Pacer own_pacer(execution);
    for (std::size_t s = first; s < last; ++s) {
      own_pacer.step(8 * (begin[s + 1] - begin[s]));
      sort_with_polls(execution, entries.begin() + begin[s], entries.begin() + begin[s + 1],
                      [](const Entry& a, const Entry& b) { return a.rest < b.rest; });
      for (std::uint32_t k = begin[s]; k < begin[s + 1]; ++k) new_id[entries[k].tet] = TetId{k};
    }
  });
  std::vector<Entry>().swap(entries);
  // Read in the previous order, in which neighbours are near each other. So reads hit the cache, and only
  // writes are scattered.
  std::vector<Tetrahedron> tets;
  resize_with_polls(execution, tets, count);
  parallel_for(execution, count, 2048, [&](std::size_t first, std::size_t last) {
    for (const TetId old : ids<TetId>(first, last)) {
      Tetrahedron& tet = tets[new_id[old]];
      tet = t.tets[old];
      for (TetId& n : tet.n)
        if (n != kNoTet) n = new_id[n];
    }
  });
  t.tets = std::move(tets);
  std::fill(t.tet_of_site.begin(), t.tet_of_site.end(), kNoTet);
  for (std::size_t k = count; k-- > 0;) {  // backwards, so that each site keeps its first tetrahedron
    pacer.step();
    for (const SiteId s : t.tets[k].v) t.tet_of_site[s] = TetId{k};
  }
  return new_id;
}

}  // namespace fracture
