#include <algorithm>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/incremental_detail.hpp"
#include "common/exact/in_sphere.hpp"
#include "common/exact/orient3d.hpp"

namespace fracture {
namespace {

std::string name_of(TetId t, const TetVertexId (&v)[4]) {
  return "tetrahedron " + std::to_string(t) + " (" + std::to_string(v[0]) + ", " + std::to_string(v[1]) +
         ", " + std::to_string(v[2]) + ", " + std::to_string(v[3]) + ")";
}

}  // namespace

std::optional<std::string> IncrementalDelaunay::validate() const {
  std::uint32_t live = 0;
  for (const TetId id : ids<TetId>(tets_.size())) {
    const Tet& t = tets_[id];
    if (t.v[0] == kNoVertex) continue;
    ++live;
    for (const TetVertexId v : t.v)
      if (!is_live(v)) return name_of(id, t.v) + " has the removed vertex " + std::to_string(v);
    if (exact::orient3d(position(t.v[0]), position(t.v[1]), position(t.v[2]), position(t.v[3])) <= 0)
      return name_of(id, t.v) + " is not positive";
    for (unsigned k = 0; k < 4; ++k) {
      const Link link = t.n[k];
      TetVertexId mine[3] = {t.v[kFacet[k][0]], t.v[kFacet[k][1]], t.v[kFacet[k][2]]};
      std::sort(mine, mine + 3);
      if (link == kNoLink) {
        if (mine[2] > 3) return name_of(id, t.v) + " has no neighbour " + std::to_string(k);
        continue;
      }
      if (link.tet() >= tets_.size() || tets_[link.tet()].v[0] == kNoVertex)
        return name_of(id, t.v) + " has a dead neighbour " + std::to_string(k);
      const Tet& other = tets_[link.tet()];
      const unsigned back = link.facet();
      if (other.n[back] != Link(id, k))
        return name_of(id, t.v) + ": adjacency of facet " + std::to_string(k) + " is not symmetric";
      TetVertexId theirs[3] = {other.v[kFacet[back][0]], other.v[kFacet[back][1]], other.v[kFacet[back][2]]};
      std::sort(theirs, theirs + 3);
      if (!std::equal(mine, mine + 3, theirs))
        return name_of(id, t.v) + ": facet " + std::to_string(k) + " differs from its neighbour's";
      if (exact::in_sphere(position(t.v[0]), position(t.v[1]), position(t.v[2]), position(t.v[3]),
                           position(other.v[back])) > 0)
        return name_of(id, t.v) + " has vertex " + std::to_string(other.v[back]) + " in its sphere";
    }
  }
  if (live != tet_count()) return "the free list disagrees with the tetrahedra";
  for (const TetVertexId v : ids<TetVertexId>(vertices_.size())) {
    if (!is_live(v)) continue;
    const TetId t = vertices_[v].tet;
    if (t >= tets_.size() || std::find(tets_[t].v, tets_[t].v + 4, v) == tets_[t].v + 4)
      return "vertex " + std::to_string(v) + " points to a tetrahedron that does not contain it";
    if (vertices_[v].local != kNoLocal) return "vertex " + std::to_string(v) + " kept its cavity number";
  }
  return std::nullopt;
}

}  // namespace fracture
