// Insertion by cavity (Bowyer 1981, Watson 1981): the tetrahedra whose sphere contains the new site p form a
// connected region that p sees entirely; it is emptied and its boundary joined to p.
//
// No new tetrahedron is flat although coordinates are never perturbed: if p lay in the plane of a boundary
// facet, p would have equal power to both spheres through that facet (the plane is their radical plane,
// weights included), so both tetrahedra would be in conflict or none.
#include <bit>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/incremental_detail.hpp"

namespace fracture {
namespace {
/// Cavities with up to this many vertices find the neighbour across an edge in a square table (about 16
/// vertices is usual, 98 % have fewer than 40); larger ones in a hash table. The square of it is 64 KiB of 4
/// bytes.
constexpr std::uint32_t kTableSide = 128;
constexpr std::uint32_t kEmpty = 0xffffffffu;
}  // namespace

void IncrementalDelaunay::insert_by_cavity(VertexId v, TetId start) {
  grow_cavity(position(v), start);
  fill_cavity(v);
}

void IncrementalDelaunay::grow_cavity(const Vec3d& p, TetId start) {
  next_visit();
  const std::uint32_t in = visit_, out = visit_ + 1;
  cavity_.clear();
  boundary_.clear();
  cavity_.push_back(start);
  tets_[start].mark = in;
  std::uint64_t tests = 0;
  for (std::size_t i = 0; i < cavity_.size(); ++i) {
    const Tet& t = tets_[cavity_[i]];
    for (int k = 0; k < 4; ++k) {
      const Link link = t.n[k];
      if (link != kNoLink) {
        Tet& neighbour = tets_[link >> 2];
        if (neighbour.mark == in) continue;
        if (neighbour.mark != out) {
          ++tests;
          if (in_conflict(neighbour, 0, p)) {
            neighbour.mark = in;
            cavity_.push_back(link >> 2);
            continue;
          }
          neighbour.mark = out;
        }
      }
      const std::uint8_t* f = kFacet[k];
      boundary_.push_back({{t.v[f[0]], t.v[f[1]], t.v[f[2]]}, link});
    }
  }
  counters_.sphere_tests += tests;
}

void IncrementalDelaunay::fill_cavity(VertexId v) {
  const Vec3d p = position(v);

  // Slots for the new tetrahedra: those of the cavity first, they are in the cache.
  const std::size_t count = boundary_.size();
  while (cavity_.size() > count) {
    free_tet(cavity_.back());
    cavity_.pop_back();
  }
  while (cavity_.size() < count) cavity_.push_back(new_tet());

  local_.clear();
  const auto number = [&](VertexId w, TetId t) {
    Vertex& vertex = vertices_[w];
    if (vertex.local == kNoLocal) {
      vertex.local = static_cast<std::uint32_t>(local_.size());
      vertex.tet = t;
      const Vec3d d{vertex.x - p.x, vertex.y - p.y, vertex.z - p.z};
      local_.push_back({d, dot(d, d), w});
    }
    return vertex.local;
  };

  // Each new tetrahedron is (p, a, b, c) over the boundary facet abc. Its facet opposite a holds the edge bc;
  // the new neighbour there is the one whose facet has the edge in the other direction.
  if (edge_table_.size() < kTableSide * kTableSide) edge_table_.resize(kTableSide * kTableSide);
  bool small = true;
  fresh_.resize(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Facet& f = boundary_[i];
    const TetId id = cavity_[i];
    const std::uint32_t a = number(f.v[0], id), b = number(f.v[1], id), c = number(f.v[2], id);
    Tet& t = tets_[id];
    t.v[0] = v;
    t.v[1] = f.v[0];
    t.v[2] = f.v[1];
    t.v[3] = f.v[2];
    t.n[0] = f.outer;
    t.mark = 0;
    if (f.outer != kNoLink) tets_[f.outer >> 2].n[f.outer & 3] = 4 * id;
    const LocalVertex &la = local_[a], &lb = local_[b], &lc = local_[c];
    set_sphere(t, la.d, lb.d, lc.d, la.lift, lb.lift, lc.lift);
    fresh_[3 * i] = a;
    fresh_[3 * i + 1] = b;
    fresh_[3 * i + 2] = c;
    if (local_.size() <= kTableSide) {
      edge_table_[b * kTableSide + c] = 4 * id + 1;
      edge_table_[c * kTableSide + a] = 4 * id + 2;
      edge_table_[a * kTableSide + b] = 4 * id + 3;
    } else {
      small = false;
    }
  }
  if (small) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t a = fresh_[3 * i], b = fresh_[3 * i + 1], c = fresh_[3 * i + 2];
      Tet& t = tets_[cavity_[i]];
      t.n[1] = edge_table_[c * kTableSide + b];
      t.n[2] = edge_table_[a * kTableSide + c];
      t.n[3] = edge_table_[b * kTableSide + a];
    }
  } else {
    // Open addressing over the facets (link = slot in tets_ and facet), keyed by the directed edge.
    std::vector<std::uint32_t>& table = edge_table_;
    const std::size_t size = std::bit_ceil(6 * count);
    table.assign(std::max<std::size_t>(size, kTableSide * kTableSide), kEmpty);
    const auto slot_of = [&](std::uint32_t from, std::uint32_t to) {
      std::uint64_t h = (static_cast<std::uint64_t>(from) << 32 | to) * 0x9e3779b97f4a7c15ull;
      return static_cast<std::size_t>(h ^ h >> 29) & (size - 1);
    };
    const auto edge = [&](std::uint32_t entry) {  // entry = 3 * facet + corner opposite the edge
      const std::uint32_t base = entry / 3 * 3, k = entry % 3;
      return std::array{fresh_[base + (k + 1) % 3], fresh_[base + (k + 2) % 3]};
    };
    for (std::uint32_t entry = 0; entry < 3 * count; ++entry) {
      const auto [from, to] = edge(entry);
      std::size_t s = slot_of(from, to);
      while (table[s] != kEmpty) s = (s + 1) & (size - 1);
      table[s] = entry;
    }
    for (std::uint32_t entry = 0; entry < 3 * count; ++entry) {
      const auto [from, to] = edge(entry);
      std::size_t s = slot_of(to, from);
      while (edge(table[s]) != std::array{to, from}) s = (s + 1) & (size - 1);
      tets_[cavity_[entry / 3]].n[1 + entry % 3] = 4 * cavity_[table[s] / 3] + 1 + table[s] % 3;
    }
  }
  for (const LocalVertex& l : local_) vertices_[l.vertex].local = kNoLocal;
  vertices_[v].tet = cavity_[0];
}

}  // namespace fracture
