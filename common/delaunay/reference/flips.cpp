// Insertion by flips: the paper's InsertOnePoint and Flip (sections 4.1 and 4.3; Ledoux 2007), here for the
// power diagram of the one tie rule. Edelsbrunner & Shah 1996 prove that it terminates.
//
// Difference from the paper: its flip14 for a site on a facet or an edge creates flat tetrahedra, which its
// case 4 removes again. This code begins with flip26 or n→2n instead. So there is never a flat tetrahedron,
// and case 4 is handled before the queue starts.
#include <algorithm>
#include <utility>

#include "common/delaunay/incremental_detail.hpp"
#include "common/delaunay/reference/reference_delaunay.hpp"

namespace fracture {

// Replaces a set of tetrahedra by another set with the same outer facets. Facets are matched by their
// vertices.
void ReferenceDelaunay::replace(std::span<const TetId> removed,
                                std::span<const std::array<TetVertexId, 4>> created) {
  sides_.clear();
  const auto add_side = [&](const TetVertexId(&v)[4], unsigned k, Link link) {
    const std::uint8_t* f = kFacet[k];
    std::array<TetVertexId, 3> key{v[f[0]], v[f[1]], v[f[2]]};
    if (key[1] < key[0]) std::swap(key[0], key[1]);
    if (key[2] < key[1]) std::swap(key[1], key[2]);
    if (key[1] < key[0]) std::swap(key[0], key[1]);
    sides_.push_back({key, link});
  };
  next_visit();
  for (const TetId t : removed) tets_[t].mark = visit_;
  for (const TetId id : removed) {
    const Tet& t = tets_[id];
    for (unsigned k = 0; k < 4; ++k)
      if (t.n[k] == kNoLink || tets_[t.n[k].tet()].mark != visit_) add_side(t.v, k, t.n[k]);
  }
  for (const TetId t : removed) free_tet(t);
  counters_.tets_created += created.size();
  for (const std::array<TetVertexId, 4>& v : created) {
    const TetId id = make_tet(v[0], v[1], v[2], v[3]);
    for (unsigned k = 0; k < 4; ++k) add_side(tets_[id].v, k, Link(id, k));
    queue_.push_back(id);
  }
  const auto less = [](const Side& a, const Side& b) { return a.key < b.key; };
  if (sides_.size() <= 32) {
    for (std::size_t i = 1; i < sides_.size(); ++i)
      for (std::size_t j = i; j > 0 && less(sides_[j], sides_[j - 1]); --j)
        std::swap(sides_[j], sides_[j - 1]);
  } else {
    std::sort(sides_.begin(), sides_.end(), less);
  }
  for (std::size_t i = 0; i + 1 < sides_.size(); i += 2) {
    const Link a = sides_[i].link, b = sides_[i + 1].link;
    if (sides_[i].key != sides_[i + 1].key) throw InternalError("flip: a facet has no partner");
    if (a != kNoLink) link_back(a) = b;
    if (b != kNoLink) link_back(b) = a;
  }
}

IncrementalDelaunay::Insertion ReferenceDelaunay::insert_by_flips(const Vec3d& p) {
  return insert_with(p, [this](TetVertexId v, const Located& at) {
    begin_flips(v, at);
    flip_around(v);
  });
}

int ReferenceDelaunay::orient(const std::array<TetVertexId, 4>& v) const {
  return orient3d(position(v[0]), position(v[1]), position(v[2]), position(v[3]));
}

void ReferenceDelaunay::begin_flips(TetVertexId p, const Located& at) {
  using V4 = std::array<TetVertexId, 4>;
  const auto with = [p](const Tet& t, unsigned k) {  // vertex k replaced by p, with p first, still positive
    return V4{p, t.v[kFacet[k][0]], t.v[kFacet[k][1]], t.v[kFacet[k][2]]};
  };
  removed_.clear();
  created_.clear();
  queue_.clear();
  const Tet& first = tets_[at.tet];
  const int zeros = __builtin_popcount(at.zeros);
  removed_.push_back(at.tet);
  if (zeros == 0) {  // flip14
    for (unsigned k = 0; k < 4; ++k) created_.push_back(with(first, k));
    ++flips_.flip14;
  } else if (zeros == 1) {  // flip26: p on facet k, shared with one neighbour
    const unsigned facet = static_cast<unsigned>(__builtin_ctz(at.zeros));
    const Link link = first.n[facet];
    for (unsigned k = 0; k < 4; ++k) {
      if (k != facet) created_.push_back(with(first, k));
      if (k != link.facet()) created_.push_back(with(tets_[link.tet()], k));
    }
    removed_.push_back(link.tet());
    ++flips_.flip26;
  } else {  // n→2n: p on the edge ab of n tetrahedra
    unsigned ends[2], count = 0;
    for (unsigned k = 0; k < 4; ++k)
      if (!(at.zeros >> k & 1)) ends[count++] = k;
    const TetVertexId a = first.v[ends[0]], b = first.v[ends[1]];
    // Turn around the edge: leave each tetrahedron through the facet opposite the vertex on the facet by
    // which it was entered.
    TetId id = at.tet;
    unsigned leave = static_cast<unsigned>(__builtin_ctz(at.zeros));
    do {
      const Tet& t = tets_[id];
      unsigned other = 0;
      for (unsigned k = 0; k < 4; ++k) {
        if (t.v[k] == a || t.v[k] == b)
          created_.push_back(with(t, k));
        else if (k != leave)
          other = k;
      }
      if (id != at.tet) removed_.push_back(id);
      const TetVertexId pivot = t.v[other];  // on the crossed facet; the next step leaves opposite it
      id = t.n[leave].tet();
      const Tet& next = tets_[id];
      for (unsigned k = 0; k < 4; ++k)
        if (next.v[k] == pivot) leave = k;
    } while (id != at.tet);
    ++flips_.flip_n2n;
  }
  replace(removed_, created_);
}

// The queue contains tetrahedra t = (p, a, b, c) whose facet abc may not be locally Delaunay; d is the vertex
// beyond it.
//
//   case 1: pd passes through    case 2: pd passes beyond one   case 3: pd meets the edge ab
//   the inside of abc            edge ab whose third            exactly and ab has four
//                                tetrahedron is pabd            tetrahedra (config44)
//          p                            p                             p ---- c
//         /|\                          /| \                          /| \  / |
//        / | \                        / |  \                        / |  \/  |
//       a--+--c     flip23           a--|---c    flip32            a--+--/---b     flip44
//        \ | /                        \ |  /                        \ | /\  |
//         \|/                          \| /                          \|/  \ |
//          d                            d                             d ---- e
//
//   case 4 (p in the plane of abc: t is flat) does not occur, see above. In every other position, the facet
//   is left alone: another flip must come first, and the tetrahedra that it creates enter the queue again.
void ReferenceDelaunay::flip_around(TetVertexId p) {
  const Vec3d site = position(p);
  while (!queue_.empty()) {
    const TetId id = queue_.back();
    queue_.pop_back();
    const Tet& t = tets_[id];
    if (t.v[0] != p) continue;  // removed, or its slot is reused without p (p is always first)
    const Link link = t.n[0];
    if (link == kNoLink) continue;
    const TetId outer = link.tet();
    const Tet& o = tets_[outer];
    ++counters_.sphere_tests;
    if (!in_conflict(o, query(site))) continue;

    const TetVertexId abc[3] = {t.v[1], t.v[2], t.v[3]};
    const TetVertexId d = o.v[link.facet()];
    // side[k]: whether d is on the same side as vertex k of the plane through p and the other two vertices.
    // Created tetrahedron k has k replaced by d, and is positive exactly in this case.
    std::array<std::array<TetVertexId, 4>, 3> tuple;
    int side[3];
    int positive = 0, bad = -1;
    for (int k = 0; k < 3; ++k) {
      tuple[k] = {p, abc[0], abc[1], abc[2]};
      tuple[k][k + 1] = d;
      side[k] = orient(tuple[k]);
      if (side[k] > 0)
        ++positive;
      else
        bad = k;
    }
    if (positive < 2) continue;
    removed_.assign({id, outer});
    created_.clear();
    if (positive == 3) {
      created_.assign(tuple.begin(), tuple.end());
      ++flips_.flip23;
    } else {
      // The edge ab opposite the refused vertex c = abc[bad]: the tetrahedra beyond pab and beyond abd.
      const unsigned c_in_t = static_cast<unsigned>(bad) + 1;
      unsigned c_in_o = 0;
      for (unsigned k = 0; k < 4; ++k)
        if (o.v[k] == abc[bad]) c_in_o = k;
      const Link behind_t = t.n[c_in_t], behind_o = o.n[c_in_o];
      if (behind_t == kNoLink || behind_o == kNoLink) continue;
      const TetId tb = behind_t.tet(), tc = behind_o.tet();
      for (int k = 0; k < 3; ++k)
        if (k != bad) created_.push_back(tuple[k]);
      if (side[bad] < 0) {
        if (tb != tc) continue;
        removed_.push_back(tb);
        ++flips_.flip32;
      } else {
        // config44: tb = (p, a, b, e) and tc = (d, a, b, e) are neighbours.
        if (tb == tc) continue;
        const TetVertexId e = tets_[tb].v[behind_t.facet()];
        if (tets_[tc].v[behind_o.facet()] != e) continue;
        // Below the plane pabd, e replaces c; the mirrored order keeps the tetrahedra positive.
        for (int k = 0; k < 2; ++k) {
          std::array<TetVertexId, 4> mirrored = created_[k];
          std::replace(mirrored.begin(), mirrored.end(), abc[bad], e);
          std::swap(mirrored[2], mirrored[3]);
          created_.push_back(mirrored);
        }
        removed_.push_back(tb);
        removed_.push_back(tc);
        ++flips_.flip44;
      }
    }
    replace(removed_, created_);
  }
}

}  // namespace fracture
