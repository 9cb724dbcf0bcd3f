// Removal of a site (Devillers & Teillaud 2003). The tetrahedra that must fill the star of v have link
// vertices only and empty spheres, so they are tetrahedra of the link vertices' own Delaunay
// tetrahedralization, computed with the same predicates and the same tie rule; those inside the star are
// copied and glued along its boundary. flip41 alone is not enough (not even in a lattice); it is kept as the
// fast path for a link of four vertices.
//
// The link may contain corners of the big tetrahedron T, so the scratch structure needs a bigger one, and its
// corners must lie in no sphere that matters. Let B be a ball without corners of T inside that has a site x
// of U in its closure, and s another point of B beyond T; the segment xs leaves T at y in a facet, and y =
// sum of l_i t_i over its corners. The power of y to B is at most -|y-x||s-y|, the powers of the t_i are not
// negative, so |y-x||s-y| <= sum l_i |t_i-y|^2 <= (2 sqrt(2) K)^2 / 3. U keeps a distance of more than K/8
// from the facets of T, hence |s-y| < 22 K and s is less than 24 K from the centre. The scratch corners are
// sqrt(3) * 32 K away. (The one tetrahedron without a site, T itself, has radius sqrt(3) K.)
#include <algorithm>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/incremental_detail.hpp"

namespace fracture {
namespace {

constexpr double kScratchFactor = 32;

std::array<VertexId, 3> sorted(std::array<VertexId, 3> v) {
  std::sort(v.begin(), v.end());
  return v;
}

/// Whether two orders of the same three vertices turn the same way.
bool same_turn(const std::array<VertexId, 3>& a, const std::array<VertexId, 3>& b) {
  for (int k = 0; k < 3; ++k)
    if (a[0] == b[k]) return a[1] == b[(k + 1) % 3];
  return false;
}

}  // namespace

// The tetrahedra at v into cavity_, their facets opposite v into boundary_, in the order of grow_cavity().
void IncrementalDelaunay::collect_star(VertexId v) {
  next_visit();
  cavity_.assign(1, vertices_[v].tet);
  boundary_.clear();
  tets_[cavity_[0]].mark = visit_;
  for (std::size_t i = 0; i < cavity_.size(); ++i) {
    const Tet& t = tets_[cavity_[i]];
    for (unsigned k = 0; k < 4; ++k) {
      if (t.v[k] == v) {
        const std::uint8_t* f = kFacet[k];
        boundary_.push_back({{t.v[f[0]], t.v[f[1]], t.v[f[2]]}, t.n[k]});
      } else if (tets_[t.n[k] >> 2].mark != visit_) {
        tets_[t.n[k] >> 2].mark = visit_;
        cavity_.push_back(t.n[k] >> 2);
      }
    }
  }
}

void IncrementalDelaunay::remove(VertexId v) {
  if (v < 4 || !is_live(v))
    throw InternalError("remove: vertex " + std::to_string(v) + " is not a live site");
  collect_star(v);

  if (cavity_.size() == 4) {  // flip41
    const Facet& base = boundary_[0];
    VertexId apex = kNoVertex;
    for (const VertexId w : boundary_[1].v)
      if (std::find(base.v, base.v + 3, w) == base.v + 3) apex = w;
    removed_.assign(cavity_.begin(), cavity_.end());
    const std::array<VertexId, 4> whole{apex, base.v[0], base.v[1], base.v[2]};
    replace(removed_, {&whole, 1});
    last_ = vertices_[apex].tet;
    ++counters_.flips41;
  } else {
    fill_star(v);
  }
  vertices_[v].tet = kNoTet;
  free_vertices_.push_back(v);
}

void IncrementalDelaunay::fill_star(VertexId v) {
  // Tetrahedralize the link alone.
  BigTetrahedron outer = big_;
  outer.half = kScratchFactor * big_.half;
  outer.domain = {};
  for (const Vec3d& c : big_.corners()) outer.domain.add(c);
  IncrementalDelaunay scratch(outer);
  std::vector<VertexId> vertex_of(4, kNoVertex);  // scratch id -> our id
  for (const Facet& f : boundary_)
    for (const VertexId w : f.v) {
      if (vertices_[w].local != kNoLocal) continue;
      vertices_[w].local = static_cast<std::uint32_t>(vertex_of.size());
      vertex_of.push_back(w);
    }
  for (std::size_t i = 4; i < vertex_of.size(); ++i) {
    vertices_[vertex_of[i]].local = kNoLocal;
    if (scratch.insert(position(vertex_of[i])).vertex != i)
      throw InternalError("remove: link vertices are not distinct");
  }

  // The boundary by facet, in our ids.
  struct Wall {
    std::array<VertexId, 3> key, turn;
    Link outer;
  };
  std::vector<Wall> walls;
  walls.reserve(boundary_.size());
  for (const Facet& f : boundary_) {
    const std::array<VertexId, 3> turn{f.v[0], f.v[1], f.v[2]};
    walls.push_back({sorted(turn), turn, f.outer});
  }
  std::sort(walls.begin(), walls.end(), [](const Wall& a, const Wall& b) { return a.key < b.key; });
  const auto facet_of = [&](const Tet& t, unsigned k) {
    return std::array<VertexId, 3>{vertex_of[t.v[kFacet[k][0]]], vertex_of[t.v[kFacet[k][1]]],
                                   vertex_of[t.v[kFacet[k][2]]]};
  };
  const auto wall_of = [&](const std::array<VertexId, 3>& facet) -> const Wall* {
    const std::array<VertexId, 3> key = sorted(facet);
    const auto it =
        std::lower_bound(walls.begin(), walls.end(), key,
                         [](const Wall& w, const std::array<VertexId, 3>& k) { return w.key < k; });
    return it != walls.end() && it->key == key ? &*it : nullptr;
  };

  // Inside the star are the scratch tetrahedra on the inner side of a wall, and what is reached from them
  // without crossing one.
  std::vector<TetId> inside;
  std::vector<TetId> slot(scratch.tets_.size(), kNoTet);  // scratch tetrahedron -> ours
  for (const TetId t : cavity_) free_tet(t);
  const auto take = [&](TetId s) {
    if (slot[s] != kNoTet) return;
    for (const VertexId w : scratch.tets_[s].v)
      if (w < 4)
        throw InternalError("remove: the star of vertex " + std::to_string(v) + " is not filled by its link");
    slot[s] = new_tet();
    inside.push_back(s);
  };
  for (TetId s = 0; s < scratch.tets_.size(); ++s) {
    const Tet& t = scratch.tets_[s];
    if (t.v[0] == kNoVertex) continue;
    for (unsigned k = 0; k < 4; ++k) {
      const std::array<VertexId, 3> facet = facet_of(t, k);
      const Wall* wall = wall_of(facet);
      if (wall && same_turn(wall->turn, facet)) take(s);
    }
  }
  std::size_t glued = 0;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const TetId s = inside[i], id = slot[s];
    const Tet& from = scratch.tets_[s];
    Tet t{{vertex_of[from.v[0]], vertex_of[from.v[1]], vertex_of[from.v[2]], vertex_of[from.v[3]]},
          {},
          {},
          0,
          0};
    for (unsigned k = 0; k < 4; ++k) {
      if (const Wall* wall = wall_of(facet_of(from, k))) {
        ++glued;
        t.n[k] = wall->outer;
        if (wall->outer != kNoLink) tets_[wall->outer >> 2].n[wall->outer & 3] = 4 * id + k;
      } else {
        take(from.n[k] >> 2);
        t.n[k] = 4 * slot[from.n[k] >> 2] + (from.n[k] & 3);
      }
    }
    set_sphere(t);
    tets_[id] = t;
    for (const VertexId w : t.v) vertices_[w].tet = id;
  }
  if (glued != walls.size())
    throw InternalError("remove: " + std::to_string(walls.size() - glued) + " facets of the star of vertex " +
                        std::to_string(v) + " are open");
  last_ = slot[inside[0]];
}

}  // namespace fracture
