// Insertion by cavity (Bowyer 1981, Watson 1981). The tetrahedra whose sphere contains the new site p form a
// connected region that is entirely visible from p. They are removed, and the region's boundary is joined to
// p.
//
// No new tetrahedron is flat, although coordinates are never perturbed. If p were in the plane of a boundary
// facet, it would have equal power to both spheres through that facet (the plane is their radical plane,
// including weights). Then both tetrahedra or neither would be in conflict.
#include <algorithm>
#include <bit>

#include "common/base/random.hpp"
#include "common/delaunay/incremental.hpp"
#include "common/delaunay/incremental_detail.hpp"

namespace fracture {
namespace {
/// Cavities with up to this many vertices find the neighbour across an edge in a square table of 64 KiB.
/// (Random sites give 27 facets, so about 16 vertices by Euler's formula.) Larger cavities, such as at the
/// centre of a sphere, use a hash table.
constexpr std::uint32_t kTableSide = 128;
constexpr std::uint32_t kEmpty = 0xffffffffu;
}  // namespace

IncrementalDelaunay::Insertion IncrementalDelaunay::insert(const Vec3d& p) {
  return insert_with(p, [this](TetVertexId v, const Located& at) {
    grow_cavity(query(position(v)), at.tet);
    fill_cavity(v);
  });
}

IncrementalDelaunay::Insertion IncrementalDelaunay::insert_in_part(const Vec3d& p, TetVertexId near) {
  if (tet_count() > options_.max_tets) return {Status::kFull, kNoVertex};
  const TetVertexId v = new_vertex(p);
  TetId start = kNoTet;
  if (const std::optional<Located> at = walk(position(v), vertices_[near].tet)) {
    start = at->tet;
  } else {
    for (const TetId t : ids<TetId>(tets_.size())) {
      poll_in_large_cavity(t);
      if (tets_[t].v[0] == kNoVertex || !in_conflict(tets_[t], query(position(v)))) continue;
      start = t;
      break;
    }
    if (start == kNoTet) throw InternalError("a site is in conflict with no tetrahedron of its part");
  }
  grow_cavity(query(position(v)), start);
  fill_cavity(v);
  last_ = vertices_[v].tet;
  return {Status::kInserted, v};
}

// Whether a tetrahedron is in conflict is unpredictable, and whether it was visited before hardly less so. So
// the code branches on neither: a tetrahedron visited again is tested again, both outcomes are written, and
// the result advances the counters.
void IncrementalDelaunay::grow_cavity(const Query& q, TetId start) {
  next_visit();
  const std::uint32_t in = visit_, out = visit_ + 1;
  if (cavity_.size() < 8) cavity_.resize(64);
  if (boundary_.size() < 8) boundary_.resize(64);
  // Local copies, because the compiler must assume that the writes below may change the members.
  Tet* const tets = tets_.data();
  Link* cavity = cavity_.data();
  Facet* boundary = boundary_.data();
  std::size_t cavity_count = 0, boundary_count = 0;

  // Called three times per tetrahedron of the cavity. Not inlined, it takes a third more instructions.
  const auto test = [&](const Tet& t, unsigned k) __attribute__((always_inline)) {
    const Link link = t.n[k];
    const std::uint8_t* f = kFacet[k];
    boundary[boundary_count] = {{t.v[f[0]], t.v[f[1]], t.v[f[2]]}, link};
    if (link == kNoLink) [[unlikely]] {
      ++boundary_count;
      return;
    }
    Tet& neighbour = tets[link.tet()];
    const bool met_inside = neighbour.mark == in;
    auto [conflict, certain] = filter(neighbour, q);
    if (!certain) [[unlikely]]
      conflict = met_inside || (neighbour.mark != out && in_conflict_exact(neighbour, q.p));
    cavity[cavity_count] = link;
    cavity_count += conflict & !met_inside;
    boundary_count += !conflict;
    neighbour.mark = out - conflict;
  };

  tets[start].mark = in;
  cavity[cavity_count++] = Link(start, 0);
  test(tets[start], 0);
  for (std::size_t i = 0; i < cavity_count; ++i) {
    poll_in_large_cavity(i);
    if (cavity_count + 4 > cavity_.size()) {
      cavity_.resize(2 * cavity_.size());
      cavity = cavity_.data();
    }
    if (boundary_count + 4 > boundary_.size()) {
      boundary_.resize(2 * boundary_.size());
      boundary = boundary_.data();
    }
    const Tet& t = tets[cavity[i].tet()];
    const unsigned entry = cavity[i].facet();
    test(t, (entry + 1) & 3);
    test(t, (entry + 2) & 3);
    test(t, (entry + 3) & 3);
  }
  cavity_count_ = cavity_count;
  boundary_count_ = boundary_count;
  counters_.sphere_tests += cavity_count + boundary_count - 1;
}

void IncrementalDelaunay::fill_cavity(TetVertexId v) {
  take_slots();
  const std::uint32_t locals = make_tets(v);
  measure_edges(v, locals);
  if (locals <= kTableSide) [[likely]] {
    finish_tets<true>(v);
  } else {
    finish_tets<false>(v);
    join_by_hash();
  }
  vertices_[v].tet = slot(0);
}

// Reserves one slot per boundary facet: first those of the cavity, because they are in the cache.
void IncrementalDelaunay::take_slots() {
  const std::size_t count = boundary_count_;
  if (cavity_.size() < count) cavity_.resize(2 * count);
  while (cavity_count_ > count) free_tet(cavity_[--cavity_count_].tet());
  while (cavity_count_ < count) cavity_[cavity_count_++] = Link(new_tet(), 0);
}

// Each new tetrahedron is (p, a, b, c) over the boundary facet abc. Its facet opposite a contains the edge
// bc; the new neighbour there is the one whose facet has this edge in the other direction. This step joins
// the new tetrahedra to the outside, numbers the vertices of the cavity, and returns their count. If they are
// few, it also enters the facets in the table by their edges.
std::uint32_t IncrementalDelaunay::make_tets(TetVertexId v) {
  const std::size_t count = boundary_count_;
  if (local_.size() < count + 8) local_.resize(2 * count + 8);
  if (fresh_.size() < 3 * count) fresh_.resize(6 * count);
  if (edge_table_.empty()) edge_table_.resize(kTableSide * kTableSide);
  Tet* const tets = tets_.data();
  Vertex* const vertices = vertices_.data();
  TetVertexId* const local_vertices = local_.data();
  std::uint32_t* fresh = fresh_.data();
  Link* const table = edge_table_.data();
  std::uint32_t locals = 0;
  const auto number = [&](TetVertexId w, TetId t) {
    Vertex& vertex = vertices[w];
    const bool is_new = vertex.local == kNoLocal;
    const std::uint32_t local = is_new ? locals : vertex.local;
    local_vertices[locals] = w;
    locals += is_new;
    vertex.local = local;
    vertex.tet = t;
    return local;
  };
  for (std::size_t i = 0; i < count; ++i, fresh += 3) {
    poll_in_large_cavity(i);
    const Facet f = boundary_[i];
    const TetId id = slot(i);
    const std::uint32_t a = number(f.v[0], id), b = number(f.v[1], id), c = number(f.v[2], id);
    Tet& t = tets[id];
    t.v[0] = v;
    t.v[1] = f.v[0];
    t.v[2] = f.v[1];
    t.v[3] = f.v[2];
    t.n[0] = f.outer;
    t.mark = 0;
    if (f.outer != kNoLink) [[likely]]
      tets[f.outer.tet()].n[f.outer.facet()] = Link(id, 0);
    fresh[0] = a;
    fresh[1] = b;
    fresh[2] = c;
    if (locals <= kTableSide) [[likely]] {
      table[b * kTableSide + c] = Link(id, 1);
      table[c * kTableSide + a] = Link(id, 2);
      table[a * kTableSide + b] = Link(id, 3);
    }
  }
  counters_.tets_created += count;
  return locals;
}

// Last use of the vertices' local numbers, which are reset afterwards.
void IncrementalDelaunay::measure_edges(TetVertexId v, std::uint32_t locals) {
  const Vec3d p = position(v);
  if (edges_.size() < locals) edges_.resize(2 * locals);
  for (std::uint32_t i = 0; i < locals; ++i) {
    Vertex& vertex = vertices_[local_[i]];
    vertex.local = kNoLocal;
    const Vec3d to = Vec3d{vertex.x, vertex.y, vertex.z} - p;
    edges_[i] = {{to.x, to.y, to.z}, dot(to, to)};
  }
}

// Computes the spheres of the new tetrahedra, two at a time. With kJoin, also joins neighbours that are in
// the table.
template <bool kJoin>
void IncrementalDelaunay::finish_tets(TetVertexId v) {
  using delaunay_detail::Two;
  const Vec3d normalized_p = normalized(position(v));
  const std::size_t count = boundary_count_;
  Tet* const tets = tets_.data();
  const Link* const slots = cavity_.data();
  const std::uint32_t* const fresh = fresh_.data();
  const Edge* const edges = edges_.data();
  const Link* const table = edge_table_.data();
  for (std::size_t i = 0; i < count; i += 2) {
    poll_in_large_cavity(i + 1);
    const std::size_t j = std::min(i + 1, count - 1);
    const std::uint32_t *const of_i = fresh + 3 * i, *const of_j = fresh + 3 * j;
    const auto both = [&](int k) __attribute__((always_inline)) {
      const Edge &e = edges[of_i[k]], &f = edges[of_j[k]];
      return delaunay_detail::Edge<Two>{{Two{e.to.x, f.to.x}, Two{e.to.y, f.to.y}, Two{e.to.z, f.to.z}},
                                        Two{e.lift, f.lift}};
    };
    const auto sphere =
        delaunay_detail::circumsphere<Two>(normalized_p, inverse_half_, both(0), both(1), both(2));
    const auto put = [&](Tet & t, const std::uint32_t* local, int lane) __attribute__((always_inline)) {
      t.center[0] = sphere.center.x[lane];
      t.center[1] = sphere.center.y[lane];
      t.center[2] = sphere.center.z[lane];
      t.radius2 = static_cast<float>(sphere.radius2[lane]);
      if (!kJoin) return;
      const std::uint32_t a = local[0], b = local[1], c = local[2];
      t.n[1] = table[c * kTableSide + b];
      t.n[2] = table[a * kTableSide + c];
      t.n[3] = table[b * kTableSide + a];
    };
    put(tets[slots[i].tet()], of_i, 0);
    put(tets[slots[j].tet()], of_j, 1);
  }
}

// Open addressing, keyed by the directed edge. An entry identifies the facet that has the edge: 3 * slot +
// corner opposite the edge.
void IncrementalDelaunay::join_by_hash() {
  const std::size_t count = boundary_count_;
  std::vector<std::uint32_t>& table = edge_hash_;
  const std::size_t size = std::bit_ceil(6 * count);
  table.assign(size, kEmpty);
  const auto slot_of = [&](std::uint32_t from, std::uint32_t to) {
    std::uint64_t h = (static_cast<std::uint64_t>(from) << 32 | to) * kGoldenGamma;
    return static_cast<std::size_t>(h ^ h >> 29) & (size - 1);
  };
  const auto edge = [&](std::uint32_t entry) {
    const std::uint32_t base = entry / 3 * 3, k = entry % 3;
    return std::array{fresh_[base + (k + 1) % 3], fresh_[base + (k + 2) % 3]};
  };
  for (std::uint32_t entry = 0; entry < 3 * count; ++entry) {
    poll_in_large_cavity(entry);
    const auto [from, to] = edge(entry);
    std::size_t s = slot_of(from, to);
    while (table[s] != kEmpty) s = (s + 1) & (size - 1);
    table[s] = entry;
  }
  for (std::uint32_t entry = 0; entry < 3 * count; ++entry) {
    poll_in_large_cavity(entry);
    const auto [from, to] = edge(entry);
    std::size_t s = slot_of(to, from);
    while (edge(table[s]) != std::array{to, from}) s = (s + 1) & (size - 1);
    tets_[slot(entry / 3)].n[1 + entry % 3] = Link(slot(table[s] / 3), 1 + table[s] % 3);
  }
}

}  // namespace fracture
