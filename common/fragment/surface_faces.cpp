#include "common/fragment/surface_faces.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/clip/triangulate.hpp"

namespace fracture {
namespace {

void halve(const VertexId* ring, std::uint32_t first, std::uint32_t last, std::uint32_t triangle,
           std::vector<Face>& out) {
  if (last - first < 2) return;
  const std::uint32_t middle = first + (last - first) / 2;
  out.push_back({{ring[first], ring[middle], ring[last]}, triangle});
  halve(ring, first, middle, triangle, out);
  halve(ring, middle, last, triangle, out);
}

/// Fuses the polygons of one owner within one triangle.
class Fuser {
 public:
  Fuser(const RestrictedDiagram& diagram, const Ownership& ownership) : d_(diagram), ownership_(ownership) {}

  void fuse(std::uint32_t t, std::uint32_t owner, const CutPolygon* first, const CutPolygon* last,
            std::vector<Face>& out) {
    // The sides that remain: those that do not face a cell of the same owner.
    sides_.clear();
    for (const CutPolygon* p = first; p != last; ++p) {
      if (ownership_.owner_of_site[p->cell] != owner) continue;
      for (std::uint32_t k = 0; k < p->count; ++k) {
        const PolygonSide side = d_.cuts.sides[p->first + k];
        if (!is_mesh_edge(side) && ownership_.owner_of_site[side] == owner) continue;
        sides_.push_back(
            {d_.cuts.vertices[p->first + k], d_.cuts.vertices[p->first + (k + 1) % p->count], false});
      }
    }
    std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) { return a.from < b.from; });
    loop_.clear();
    loop_begin_.assign(1, 0);
    for (std::size_t start = 0; start < sides_.size(); ++start) {
      if (sides_[start].used) continue;
      const std::size_t loop_start = loop_.size();
      for (std::size_t s = start; !sides_[s].used; s = leaving(sides_[s].to, t)) {
        sides_[s].used = true;
        if (!is_inside_group(sides_[s].from)) loop_.push_back(sides_[s].from);
      }
      if (loop_.size() > loop_start) loop_begin_.push_back(static_cast<std::uint32_t>(loop_.size()));
    }
    project(t);
    triangulate(points_, loop_begin_, triangulation_);
    for (const auto& k : triangulation_.triangles)
      out.push_back({{loop_[k[0]], loop_[k[1]], loop_[k[2]]}, t});
  }

 private:
  struct Side {
    VertexId from, to;
    bool used;
  };

  // In a generic diagram a vertex on the outline of a group within a triangle is left by one side.
  std::size_t leaving(VertexId v, std::uint32_t t) const {
    const auto it = std::lower_bound(sides_.begin(), sides_.end(), v,
                                     [](const Side& s, VertexId key) { return s.from < key; });
    if (it == sides_.end() || it->from != v)
      throw InternalError("the fused polygon of triangle " + std::to_string(t) + " is open at vertex " +
                          std::to_string(v));
    return static_cast<std::size_t>(it - sides_.begin());
  }

  bool is_inside_group(VertexId v) const {
    if (v < d_.cuts.first_b() || v >= d_.cuts.first_c())
      return false;  // a C vertex of three fellow cells has no side left
    const EdgeCut& cut = d_.cuts.edge_cuts[v - d_.cuts.first_b()];
    return ownership_.owner_of_site[cut.from] == ownership_.owner_of_site[cut.to];
  }

  // On the lattice, dropping the axis of the largest normal component: which triangulation is chosen may
  // depend on rounded positions, whether it closes cannot.
  void project(std::uint32_t t) {
    const auto& v = d_.solid.triangles[t];
    const Vec3d a = to_double(d_.solid.positions[v[0]]), b = to_double(d_.solid.positions[v[1]]),
                c = to_double(d_.solid.positions[v[2]]);
    const Vec3d n = cross(b - a, c - a);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(n[k]) > std::fabs(n[axis])) axis = k;
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (n[axis] < 0) std::swap(x, y);
    const Vec3d step = d_.positions.lattice.step();
    points_.clear();
    for (const VertexId id : loop_) {
      const Vec3d p = d_.point(id);
      points_.push_back({static_cast<std::int64_t>(std::nearbyint(p[x] / step[x])),
                         static_cast<std::int64_t>(std::nearbyint(p[y] / step[y]))});
    }
  }

  const RestrictedDiagram& d_;
  const Ownership& ownership_;
  std::vector<Side> sides_;
  std::vector<VertexId> loop_;
  std::vector<std::uint32_t> loop_begin_;
  std::vector<LatticePoint> points_;
  Triangulation triangulation_;
};

}  // namespace

OwnedFaces divide_surface(const RestrictedDiagram& d, const Ownership& ownership) {
  const auto& polygons = d.cuts.polygons;
  const auto triangles = static_cast<std::uint32_t>(d.solid.triangles.size());
  const auto owners = static_cast<std::uint32_t>(ownership.sites_of_owner.size());
  const auto owner_of = [&](SiteId s) { return ownership.owner_of_site[s]; };

  // The faces of triangles that several owners share, by input triangle; all other triangles stay whole.
  std::vector<Face> shared;
  std::vector<std::uint32_t> owner;             // per face of `shared`
  std::vector<std::uint32_t> whole(triangles);  // per triangle: its only owner, or kNoIndex
  OwnedFaces out;
  out.begin.assign(owners + 1, 0);
  Fuser fuser(d, ownership);
  std::vector<std::uint32_t> here;
  std::size_t p = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    if (p == polygons.size() || polygons[p].triangle != t) {  // not cut
      whole[t] = owner_of(d.cuts.label[d.solid.triangles[t][0]]);
      ++out.begin[whole[t] + 1];
      continue;
    }
    const std::size_t first = p;
    while (p < polygons.size() && polygons[p].triangle == t) ++p;
    here.clear();  // the owners in this triangle, each once
    for (std::size_t k = first; k < p; ++k) {
      const std::uint32_t o = owner_of(polygons[k].cell);
      if (std::find(here.begin(), here.end(), o) == here.end()) here.push_back(o);
    }
    if (here.size() == 1) {
      whole[t] = here[0];
      ++out.begin[whole[t] + 1];
      continue;
    }
    whole[t] = kNoIndex;
    for (const std::uint32_t o : here) {
      const CutPolygon* only = nullptr;
      std::size_t count = 0;
      for (std::size_t k = first; k < p; ++k)
        if (owner_of(polygons[k].cell) == o) {
          only = &polygons[k];
          ++count;
        }
      const std::size_t before = shared.size();
      if (count == 1 && ownership.sites_of_owner[o].size() == 1)
        halve(d.cuts.vertices.data() + only->first, 0, only->count - 1, t, shared);
      else
        fuser.fuse(t, o, polygons.data() + first, polygons.data() + p, shared);
      owner.resize(shared.size(), o);
      out.begin[o + 1] += static_cast<std::uint32_t>(shared.size() - before);
    }
  }

  // Counting sort by owner, in order of the input triangles.
  for (std::uint32_t o = 0; o < owners; ++o) out.begin[o + 1] += out.begin[o];
  out.faces.resize(out.begin[owners]);
  std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
  std::size_t s = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    if (whole[t] != kNoIndex) out.faces[next[whole[t]]++] = {d.solid.triangles[t], t};
    for (; s < shared.size() && shared[s].source == t; ++s) out.faces[next[owner[s]]++] = shared[s];
  }
  return out;
}

}  // namespace fracture
