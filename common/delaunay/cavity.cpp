// Insertion by cavity (Bowyer 1981, Watson 1981): the tetrahedra whose sphere contains the new site p form a
// connected region that p sees entirely; it is emptied and its boundary joined to p.
//
// No new tetrahedron is flat although coordinates are never perturbed: if p lay in the plane of a boundary
// facet, p would have equal power to both spheres through that facet (the plane is their radical plane,
// weights included), so both tetrahedra would be in conflict or none.
#include <bit>

#include "common/base/random.hpp"
#include "common/delaunay/incremental.hpp"
#include "common/delaunay/incremental_detail.hpp"

namespace fracture {
namespace {
/// Cavities with up to this many vertices find the neighbour across an edge in a square table of 64 KiB
/// (random sites make 27 facets, so by Euler about 16 vertices); larger ones, as around the centre of a
/// sphere, in a hash table.
constexpr std::uint32_t kTableSide = 128;
constexpr std::uint32_t kEmpty = 0xffffffffu;
}  // namespace

IncrementalDelaunay::Insertion IncrementalDelaunay::insert(const Vec3d& p) {
  return insert_with(p, [this](TetVertexId v, const Located& at) {
    grow_cavity(position(v), at.tet);
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
      if (tets_[t].v[0] == kNoVertex || !in_conflict(tets_[t], position(v))) continue;
      start = t;
      break;
    }
    if (start == kNoTet) throw InternalError("a site is in conflict with no tetrahedron of its part");
  }
  grow_cavity(position(v), start);
  fill_cavity(v);
  last_ = vertices_[v].tet;
  return {Status::kInserted, v};
}

// Whether a tetrahedron is in conflict is a coin toss to the branch predictor, so nothing branches on it:
// both outcomes are written and the counters advanced by the result.
void IncrementalDelaunay::grow_cavity(const Vec3d& p, TetId start) {
  next_visit();
  const std::uint32_t in = visit_, out = visit_ + 1;
  std::size_t cavity = 0, boundary = 0;
  if (cavity_.size() < 8) cavity_.resize(64);
  if (boundary_.size() < 8) boundary_.resize(64);

  // Called thrice for each tetrahedron of the cavity: outlined it takes a third more instructions.
  const auto test = [&](const Tet& t, unsigned k) __attribute__((always_inline)) {
    const Link link = t.n[k];
    const std::uint8_t* f = kFacet[k];
    boundary_[boundary] = {{t.v[f[0]], t.v[f[1]], t.v[f[2]]}, link};
    if (link == kNoLink) [[unlikely]] {
      ++boundary;
      return;
    }
    Tet& neighbour = tets_[link.tet()];
    if (neighbour.mark == in) return;
    if (neighbour.mark == out) {
      ++boundary;
      return;
    }
    const bool conflict = in_conflict(neighbour, p);
    cavity_[cavity] = link;
    cavity += conflict;
    boundary += !conflict;
    neighbour.mark = out - conflict;
  };

  tets_[start].mark = in;
  cavity_[cavity++] = Link(start, 0);
  test(tets_[start], 0);
  for (std::size_t i = 0; i < cavity; ++i) {
    poll_in_large_cavity(i);
    if (cavity + 4 > cavity_.size()) cavity_.resize(2 * cavity_.size());
    if (boundary + 4 > boundary_.size()) boundary_.resize(2 * boundary_.size());
    const Tet& t = tets_[cavity_[i].tet()];
    const unsigned entry = cavity_[i].facet();
    test(t, (entry + 1) & 3);
    test(t, (entry + 2) & 3);
    test(t, (entry + 3) & 3);
  }
  cavity_count_ = cavity;
  boundary_count_ = boundary;
  counters_.sphere_tests += cavity + boundary - 1;
}

void IncrementalDelaunay::fill_cavity(TetVertexId v) {
  take_slots();
  const std::uint32_t locals = make_tets(v);
  if (locals <= kTableSide) [[likely]]
    join_by_table();
  else
    join_by_hash();
  for (std::uint32_t i = 0; i < locals; ++i) vertices_[local_[i]].local = kNoLocal;
  vertices_[v].tet = slots_[0];
}

// One slot for each boundary facet: those of the cavity first, they are in the cache.
void IncrementalDelaunay::take_slots() {
  const std::size_t count = boundary_count_;
  if (slots_.size() < count) slots_.resize(2 * count);
  while (cavity_count_ > count) free_tet(cavity_[--cavity_count_].tet());
  for (std::size_t i = 0; i < cavity_count_; ++i) slots_[i] = cavity_[i].tet();
  for (std::size_t i = cavity_count_; i < count; ++i) slots_[i] = new_tet();
}

// Each new tetrahedron is (p, a, b, c) over the boundary facet abc. Its facet opposite a holds the edge bc;
// the new neighbour there is the one whose facet has the edge in the other direction. This step joins the
// new ones to what lies outside, numbers the vertices of the cavity and returns how many they are. As long
// as there are few, it enters the facets in the table, by their edges.
std::uint32_t IncrementalDelaunay::make_tets(TetVertexId v) {
  const Vec3d p = position(v);
  const std::size_t count = boundary_count_;
  if (local_.size() < count + 8) local_.resize(2 * count + 8);
  if (fresh_.size() < 3 * count) fresh_.resize(6 * count);
  if (edge_table_.empty()) edge_table_.resize(kTableSide * kTableSide);
  std::uint32_t locals = 0;
  const auto number = [&](Vertex& vertex, TetVertexId w, TetId t) {
    const bool is_new = vertex.local == kNoLocal;
    const std::uint32_t local = is_new ? locals : vertex.local;
    local_[locals] = w;
    locals += is_new;
    vertex.local = local;
    vertex.tet = t;
    return local;
  };
  for (std::size_t i = 0; i < count; ++i) {
    poll_in_large_cavity(i);
    const Facet& f = boundary_[i];
    const TetId id = slots_[i];
    Vertex &va = vertices_[f.v[0]], &vb = vertices_[f.v[1]], &vc = vertices_[f.v[2]];
    const std::uint32_t a = number(va, f.v[0], id), b = number(vb, f.v[1], id), c = number(vc, f.v[2], id);
    Tet& t = tets_[id];
    t.v[0] = v;
    t.v[1] = f.v[0];
    t.v[2] = f.v[1];
    t.v[3] = f.v[2];
    t.n[0] = f.outer;
    t.mark = 0;
    if (f.outer != kNoLink) [[likely]]
      link_back(f.outer) = Link(id, 0);
    fresh_[3 * i] = a;
    fresh_[3 * i + 1] = b;
    fresh_[3 * i + 2] = c;
    if (locals <= kTableSide) [[likely]] {
      edge_table_[b * kTableSide + c] = Link(id, 1);
      edge_table_[c * kTableSide + a] = Link(id, 2);
      edge_table_[a * kTableSide + b] = Link(id, 3);
    }
    const Vec3d da = Vec3d{va.x, va.y, va.z} - p, db = Vec3d{vb.x, vb.y, vb.z} - p,
                dc = Vec3d{vc.x, vc.y, vc.z} - p;
    set_sphere(t, da, db, dc, dot(da, da), dot(db, db), dot(dc, dc));
  }
  counters_.tets_created += count;
  return locals;
}

void IncrementalDelaunay::join_by_table() {
  const std::size_t count = boundary_count_;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t a = fresh_[3 * i], b = fresh_[3 * i + 1], c = fresh_[3 * i + 2];
    Tet& t = tets_[slots_[i]];
    t.n[1] = edge_table_[c * kTableSide + b];
    t.n[2] = edge_table_[a * kTableSide + c];
    t.n[3] = edge_table_[b * kTableSide + a];
  }
}

// Open addressing, keyed by the directed edge. An entry names the facet that has the edge: 3 * slot + corner
// opposite the edge.
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
    tets_[slots_[entry / 3]].n[1 + entry % 3] = Link(slots_[table[s] / 3], 1 + table[s] % 3);
  }
}

}  // namespace fracture
