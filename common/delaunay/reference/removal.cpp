// Removal of a site (Devillers & Teillaud 2003). The tetrahedra that must fill the star of v have only link
// vertices, and empty spheres. So they belong to the Delaunay tetrahedralization of the link vertices, which
// is computed with the same predicates and the same tie rule. Those inside the star are copied, and glued
// along its boundary. flip41 alone is not sufficient (not even in a lattice); it is kept as the fast path for
// a link with four vertices.
//
// The link may contain corners of the big tetrahedron T, so the scratch structure needs a bigger one, whose
// corners must not be in any relevant sphere. Let B be a ball that contains no corner of T in its interior
// and has a site x of U in its closure. Let s be another point of B, outside T. The segment xs leaves T at a
// point y in a facet, and y = sum of l_i t_i over the facet's corners. The power of y to B is at most
// -|y-x||s-y|, and the powers of the t_i are not negative, so |y-x||s-y| <= sum l_i |t_i-y|^2 <= (2 sqrt(2)
// K)^2 / 3. The distance between U and the facets of T is more than K/8. Therefore |s-y| < 22 K, and s is
// less than 24 K from the centre. The scratch corners are sqrt(3) * 32 K away. (The only tetrahedron without
// a site, T itself, has radius sqrt(3) K.)
#include <algorithm>
#include <string>

#include "common/delaunay/incremental_detail.hpp"
#include "common/delaunay/reference/reference_delaunay.hpp"

namespace fracture {
namespace {

constexpr double kScratchFactor = 32;

std::array<TetVertexId, 3> sorted(std::array<TetVertexId, 3> v) {
  std::sort(v.begin(), v.end());
  return v;
}

/// Whether two orders of the same three vertices have the same orientation.
bool same_turn(const std::array<TetVertexId, 3>& a, const std::array<TetVertexId, 3>& b) {
  for (int k = 0; k < 3; ++k)
    if (a[0] == b[k]) return a[1] == b[(k + 1) % 3];
  return false;
}

}  // namespace

// Collects the tetrahedra at v in star_, and their facets opposite v in link_facets_.
void ReferenceDelaunay::collect_star(TetVertexId v) {
  next_visit();
  star_.assign(1, vertices_[v].tet);
  link_facets_.clear();
  tets_[star_[0]].mark = visit_;
  for (std::size_t i = 0; i < star_.size(); ++i) {
    const Tet& t = tets_[star_[i]];
    for (unsigned k = 0; k < 4; ++k) {
      if (t.v[k] == v) {
        const std::uint8_t* f = kFacet[k];
        link_facets_.push_back({{t.v[f[0]], t.v[f[1]], t.v[f[2]]}, t.n[k]});
      } else if (const TetId next = t.n[k].tet(); tets_[next].mark != visit_) {
        tets_[next].mark = visit_;
        star_.push_back(next);
      }
    }
  }
}

void ReferenceDelaunay::remove(TetVertexId v) {
  if (v < 4 || !is_live(v))
    throw InternalError("remove: vertex " + std::to_string(v) + " is not a live site");
  collect_star(v);

  if (star_.size() == 4) {  // flip41
    const Facet& base = link_facets_[0];
    TetVertexId apex = kNoVertex;
    for (const TetVertexId w : link_facets_[1].v)
      if (std::find(base.v, base.v + 3, w) == base.v + 3) apex = w;
    const std::array<TetVertexId, 4> whole{apex, base.v[0], base.v[1], base.v[2]};
    replace(star_, {&whole, 1});
    last_ = vertices_[apex].tet;
    ++flips_.flip41;
  } else {
    fill_star(v);
  }
  vertices_[v].tet = kNoTet;
  free_vertices_.push_back(v);
}

/// The facets around a star, searchable by their vertices.
class ReferenceDelaunay::Walls {
 public:
  struct Wall {
    std::array<TetVertexId, 3> key, turn;  ///< the vertices: ascending; counter-clockwise seen from inside
    Link outer;                            ///< the link beyond it
  };
  explicit Walls(const std::vector<Facet>& facets) {
    walls_.reserve(facets.size());
    for (const Facet& f : facets) {
      const std::array<TetVertexId, 3> turn{f.v[0], f.v[1], f.v[2]};
      walls_.push_back({sorted(turn), turn, f.outer});
    }
    std::sort(walls_.begin(), walls_.end(), [](const Wall& a, const Wall& b) { return a.key < b.key; });
  }
  /// Null if there is no such facet.
  const Wall* find(const std::array<TetVertexId, 3>& facet) const {
    const std::array<TetVertexId, 3> key = sorted(facet);
    const auto it =
        std::lower_bound(walls_.begin(), walls_.end(), key,
                         [](const Wall& w, const std::array<TetVertexId, 3>& k) { return w.key < k; });
    return it != walls_.end() && it->key == key ? &*it : nullptr;
  }
  std::size_t size() const { return walls_.size(); }

 private:
  std::vector<Wall> walls_;
};

/// A tetrahedralization of only the vertices around the star.
struct ReferenceDelaunay::LinkDelaunay {
  ReferenceDelaunay delaunay;
  std::vector<TetVertexId> vertex_of;  ///< original id of each of its vertices; kNoVertex for its corners
};

ReferenceDelaunay::LinkDelaunay ReferenceDelaunay::tetrahedralize_link() {
  BigTetrahedron outer = big_;
  outer.half = kScratchFactor * big_.half;
  outer.domain = {};
  for (const Vec3d& c : big_.corners()) outer.domain.add(c);
  LinkDelaunay result{ReferenceDelaunay(outer), std::vector<TetVertexId>(4, kNoVertex)};
  std::vector<TetVertexId>& vertex_of = result.vertex_of;
  for (const Facet& f : link_facets_)
    for (const TetVertexId w : f.v) {
      if (vertices_[w].local != kNoLocal) continue;
      vertices_[w].local = static_cast<std::uint32_t>(vertex_of.size());
      vertex_of.push_back(w);
    }
  for (std::size_t i = 4; i < vertex_of.size(); ++i) {
    vertices_[vertex_of[i]].local = kNoLocal;
    if (result.delaunay.insert(position(vertex_of[i])).vertex != i)
      throw InternalError("remove: link vertices are not distinct");
  }
  return result;
}

/// Fills the star. Inside it are the tetrahedra of the link that are on the inner side of a wall, and all
/// that can be reached from them without crossing a wall. Each gets a slot in the original when it is
/// reached; then it is copied and glued to its neighbours.
class ReferenceDelaunay::StarFilling {
 public:
  /// Fills the star of v, which must have been collected.
  StarFilling(ReferenceDelaunay& ours, TetVertexId v)
      : ours_(ours),
        vertex_(v),
        link_(ours.tetrahedralize_link()),
        walls_(ours.link_facets_),
        slot_(link_.delaunay.tets_.size(), kNoTet) {}

  void take_those_at_walls() {
    const std::vector<Tet>& tets = link_.delaunay.tets_;
    for (const TetId s : ids<TetId>(tets.size())) {
      if (tets[s].v[0] == kNoVertex) continue;
      for (unsigned k = 0; k < 4; ++k) {
        const std::array<TetVertexId, 3> facet = facet_of(tets[s], k);
        const Walls::Wall* wall = walls_.find(facet);
        if (wall && same_turn(wall->turn, facet)) take(s);
      }
    }
  }
  /// Copies all tetrahedra taken so far, and those reached from them.
  void copy_and_glue() {
    for (std::size_t i = 0; i < inside_.size(); ++i) copy(inside_[i]);
    if (glued_ != walls_.size())
      throw InternalError("remove: " + std::to_string(walls_.size() - glued_) +
                          " facets of the star of vertex " + std::to_string(vertex_) + " are open");
  }
  TetId first() const { return slot_[inside_[0]]; }

 private:
  std::array<TetVertexId, 3> facet_of(const Tet& t, unsigned k) const {
    const std::vector<TetVertexId>& ours = link_.vertex_of;
    return {ours[t.v[kFacet[k][0]]], ours[t.v[kFacet[k][1]]], ours[t.v[kFacet[k][2]]]};
  }

  void take(TetId s) {
    if (slot_[s] != kNoTet) return;
    for (const TetVertexId w : link_.delaunay.tets_[s].v)
      if (w < 4)
        throw InternalError("remove: the star of vertex " + std::to_string(vertex_) +
                            " is not filled by its link");
    slot_[s] = ours_.new_tet();
    inside_.push_back(s);
  }

  void copy(TetId s) {
    const Tet& from = link_.delaunay.tets_[s];
    const TetId id = slot_[s];
    const std::vector<TetVertexId>& ours = link_.vertex_of;
    Tet t{{ours[from.v[0]], ours[from.v[1]], ours[from.v[2]], ours[from.v[3]]}, {}, {}, 0, 0};
    for (unsigned k = 0; k < 4; ++k) {
      if (const Walls::Wall* wall = walls_.find(facet_of(from, k))) {
        ++glued_;
        t.n[k] = wall->outer;
        if (wall->outer != kNoLink) ours_.link_back(wall->outer) = Link(id, k);
      } else {
        take(from.n[k].tet());
        t.n[k] = Link(slot_[from.n[k].tet()], from.n[k].facet());
      }
    }
    ours_.set_sphere(t);
    ours_.tets_[id] = t;
    for (const TetVertexId w : t.v) ours_.vertices_[w].tet = id;
  }

  ReferenceDelaunay& ours_;
  TetVertexId vertex_;
  LinkDelaunay link_;
  Walls walls_;
  std::vector<TetId> slot_;    // slot in the original, per tetrahedron of the link; kNoTet: not inside
  std::vector<TetId> inside_;  // tetrahedra of the link, in the order in which they are reached
  std::size_t glued_ = 0;      // number of walls already glued
};

void ReferenceDelaunay::fill_star(TetVertexId v) {
  StarFilling filling(*this, v);
  for (const TetId t : star_) free_tet(t);
  filling.take_those_at_walls();
  filling.copy_and_glue();
  last_ = filling.first();
}

}  // namespace fracture
