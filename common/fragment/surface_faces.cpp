#include "common/fragment/surface_faces.hpp"

#include <algorithm>

#include "common/fragment/outline.hpp"

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

/// Fuses the polygons of one owner within triangle t: the sides that remain are those that do not face a cell
/// of the same owner.
void fuse(const RestrictedDiagram& d, const Ownership& ownership, std::uint32_t t, std::uint32_t owner,
          const CutPolygon* first, const CutPolygon* last, Outline& outline, std::vector<Face>& out) {
  outline.clear();
  for (const CutPolygon* p = first; p != last; ++p) {
    if (ownership.owner_of_site[p->cell] != owner) continue;
    for (std::uint32_t k = 0; k < p->count; ++k) {
      const PolygonSide side = d.cuts.sides[p->first + k];
      if (!is_mesh_edge(side) && ownership.owner_of_site[side] == owner) continue;
      outline.add(d.cuts.vertices[p->first + k], d.cuts.vertices[p->first + (k + 1) % p->count]);
    }
  }
  outline.triangulate_into(t, out);
}

}  // namespace

OwnedFaces divide_surface(const RestrictedDiagram& d, const Ownership& ownership) {
  const auto& polygons = d.cuts.polygons;
  const std::uint32_t* selection = d.cuts.selection ? d.cuts.selection->data() : nullptr;
  const std::size_t count = selection ? d.cuts.selection->size() : d.solid.triangles.size();
  const auto triangle = [&](std::size_t n) {
    return selection ? selection[n] : static_cast<std::uint32_t>(n);
  };
  const auto owners = static_cast<std::uint32_t>(ownership.sites_of_owner.size());
  const auto owner_of = [&](SiteId s) { return ownership.owner_of_site[s]; };
  const auto wanted = [&](std::uint32_t o) { return ownership.wanted.empty() || ownership.wanted[o]; };

  // The faces of triangles that several owners share, by input triangle; all other triangles stay whole.
  std::vector<Face> shared;
  std::vector<std::uint32_t> owner;         // per face of `shared`
  std::vector<std::uint32_t> whole(count);  // per triangle looked at: its only owner, or kNoIndex
  OwnedFaces out;
  out.begin.assign(owners + 1, 0);
  Outline outline(d);
  std::vector<std::uint32_t> here;
  std::size_t p = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const std::uint32_t t = triangle(n);
    if (p == polygons.size() || polygons[p].triangle != t) {  // not cut
      whole[n] = owner_of(d.cuts.label[d.solid.triangles[t][0]]);
      if (wanted(whole[n]))
        ++out.begin[whole[n] + 1];
      else
        whole[n] = kNoIndex;
      continue;
    }
    const std::size_t first = p;
    while (p < polygons.size() && polygons[p].triangle == t) ++p;
    here.clear();  // the owners in this triangle, each once
    for (std::size_t k = first; k < p; ++k) {
      const std::uint32_t o = owner_of(polygons[k].cell);
      if (std::find(here.begin(), here.end(), o) == here.end()) here.push_back(o);
    }
    if (here.size() == 1 && wanted(here[0])) {
      whole[n] = here[0];
      ++out.begin[whole[n] + 1];
      continue;
    }
    whole[n] = kNoIndex;
    for (const std::uint32_t o : here) {
      if (!wanted(o)) continue;
      const CutPolygon* only = nullptr;
      std::size_t parts = 0;
      for (std::size_t k = first; k < p; ++k)
        if (owner_of(polygons[k].cell) == o) {
          only = &polygons[k];
          ++parts;
        }
      const std::size_t before = shared.size();
      if (parts == 1 && ownership.sites_of_owner[o].size() == 1)
        halve(d.cuts.vertices.data() + only->first, 0, only->count - 1, t, shared);
      else
        fuse(d, ownership, t, o, polygons.data() + first, polygons.data() + p, outline, shared);
      owner.resize(shared.size(), o);
      out.begin[o + 1] += static_cast<std::uint32_t>(shared.size() - before);
    }
  }

  // Counting sort by owner, in order of the input triangles.
  for (std::uint32_t o = 0; o < owners; ++o) out.begin[o + 1] += out.begin[o];
  out.faces.resize(out.begin[owners]);
  std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
  std::size_t s = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const std::uint32_t t = triangle(n);
    if (whole[n] != kNoIndex) out.faces[next[whole[n]]++] = {d.solid.triangles[t], t};
    for (; s < shared.size() && shared[s].source == t; ++s) out.faces[next[owner[s]]++] = shared[s];
  }
  return out;
}

}  // namespace fracture
