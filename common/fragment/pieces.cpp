#include "common/fragment/pieces.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "common/base/pacer.hpp"
#include "common/fragment/components.hpp"
#include "common/fragment/surface_faces.hpp"

namespace fracture {

Ownership Ownership::from_groups(std::uint32_t site_count, const std::vector<std::uint32_t>& groups,
                                 const Execution& execution) {
  Pacer pacer(execution);
  Ownership o;
  o.owner_of_site.resize(site_count);
  if (groups.empty()) {
    std::iota(o.owner_of_site.begin(), o.owner_of_site.end(), 0u);
    o.sites_of_owner.resize(site_count);
    for (const SiteId s : ids<SiteId>(site_count)) {
      pacer.step();
      o.sites_of_owner[s] = {s};
    }
    return o;
  }
  // (group, site), so that a group's first site is its smallest
  std::vector<std::pair<std::uint32_t, SiteId>> by_group;
  for (const SiteId s : ids<SiteId>(site_count)) by_group.emplace_back(groups[s], s);
  sort_with_polls(execution, by_group.begin(), by_group.end());
  std::vector<SiteId> first_of(site_count);
  for (std::size_t k = 0; k < by_group.size(); ++k)
    first_of[by_group[k].second] = k > 0 && by_group[k - 1].first == by_group[k].first
                                       ? first_of[by_group[k - 1].second]
                                       : by_group[k].second;
  for (const SiteId s : ids<SiteId>(site_count)) {
    pacer.step();
    if (first_of[s] == s) {
      o.owner_of_site[s] = static_cast<std::uint32_t>(o.sites_of_owner.size());
      o.sites_of_owner.emplace_back();
    } else {
      o.owner_of_site[s] = o.owner_of_site[first_of[s]];
      o.grouped = true;
    }
    o.sites_of_owner[o.owner_of_site[s]].push_back(s);
  }
  return o;
}

double signed_volume(const RestrictedDiagram& d, const Face* faces, std::size_t count, const Vec3d& origin,
                     const Execution& execution) {
  double six = 0;
  Pacer pacer(execution);
  for (std::size_t k = 0; k < count; ++k) {
    pacer.step();
    const Vec3d a = d.point(faces[k].v[0]) - origin, b = d.point(faces[k].v[1]) - origin,
                c = d.point(faces[k].v[2]) - origin;
    six += dot(a, cross(b, c));
  }
  return six / 6;
}

namespace {

/// Notes that the caps among the faces belong to this piece. Each side of a region belongs to one owner.
void note_caps(const std::vector<Face>& faces, std::uint32_t piece,
               std::vector<std::uint32_t>& piece_of_cap) {
  FaceSource last = kNoIndex;  // the faces of one region are consecutive
  for (const Face& f : faces) {
    if (!is_cap(f.source) || f.source == last) continue;
    last = f.source;
    // Uniting two pieces removes a region as a whole. A region with several pieces would leave them open.
    std::uint32_t& of_cap = piece_of_cap[f.source & ~kCapFace];
    if (of_cap != kNoIndex && of_cap != piece)
      throw InternalError("region " + std::to_string(cap_region(f.source)) +
                          " of the caps is part of pieces " + std::to_string(of_cap) + " and " +
                          std::to_string(piece));
    of_cap = piece;
  }
}

}  // namespace

Pieces gather_pieces(const RestrictedDiagram& d, const Ownership& ownership, const Execution& execution) {
  const OwnedFaces surface = divide_surface(d, ownership, execution);
  const std::size_t owners = ownership.sites_of_owner.size();

  // Cap sides by owner. A region inside a group is listed once, to connect its two sides.
  Pacer pacer(execution);
  const auto each_cap = [&](const auto& visit) {
    for (std::uint32_t r = 0; r < d.caps.regions.size(); ++r) {
      pacer.step(4);
      const std::uint32_t lo = ownership.owner_of_site[d.caps.regions[r].lo],
                          hi = ownership.owner_of_site[d.caps.regions[r].hi];
      visit(lo, cap_source(r, 0));
      if (hi != lo) visit(hi, cap_source(r, 1));
    }
  };
  std::vector<std::uint32_t> cap_begin(owners + 2, 0);
  each_cap([&](std::uint32_t owner, FaceSource) { ++cap_begin[owner + 2]; });
  for (std::size_t o = 0; o < owners; ++o) cap_begin[o + 2] += cap_begin[o + 1];
  std::vector<FaceSource> caps;
  resize_with_polls(execution, caps, cap_begin.back());
  each_cap([&](std::uint32_t owner, FaceSource side) { caps[cap_begin[owner + 1]++] = side; });
  std::vector<std::vector<std::uint32_t>> polygons(owners);
  if (ownership.grouped)
    for (std::uint32_t p = 0; p < d.cuts.polygons.size(); ++p) {
      pacer.step(4);
      const std::uint32_t o = ownership.owner_of_site[d.cuts.polygons[p].cell];
      if (ownership.sites_of_owner[o].size() > 1) polygons[o].push_back(p);
    }

  std::vector<std::vector<Component>> found(owners);
  constexpr std::size_t kBlock = 16;
  parallel_for(execution, owners, kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t o = begin; o < end; ++o) {
      if (!ownership.wanted.empty() && !ownership.wanted[o]) continue;
      found[o] = find_components(
          d, ownership,
          {static_cast<std::uint32_t>(o),
           {surface.faces.data() + surface.begin[o], surface.faces.data() + surface.begin[o + 1]},
           {caps.data() + cap_begin[o], caps.data() + cap_begin[o + 1]},
           polygons[o]},
          execution);
    }
  });

  // Each owner's pieces follow those of the previous owner.
  std::vector<std::size_t> begin(owners + 1, 0);
  for (std::size_t o = 0; o < owners; ++o) begin[o + 1] = begin[o] + found[o].size();
  Pieces out;
  resize_with_polls(execution, out.pieces, begin[owners]);
  out.piece_of_cap.assign(2 * d.caps.regions.size(), kNoIndex);
  parallel_for(execution, owners, kBlock, [&](std::size_t first, std::size_t last) {
    Pacer own_pacer(execution);
    for (std::size_t o = first; o < last; ++o) {
      std::uint32_t island = 0, last_part = kNoIndex;
      for (std::size_t n = 0; n < found[o].size(); ++n) {
        Component& c = found[o][n];
        own_pacer.step(8 + c.faces.size());
        island = c.part == last_part ? island + 1 : 0;
        last_part = c.part;
        note_caps(c.faces, static_cast<std::uint32_t>(begin[o] + n), out.piece_of_cap);
        out.pieces[begin[o] + n] = {
            {static_cast<std::uint32_t>(o)}, c.part, island, std::move(c.faces), std::move(c.bodies)};
      }
      std::vector<Component>().swap(found[o]);
    }
  });
  clear_with_polls(execution, polygons);
  return out;
}

std::optional<Pieces> with_finer_caps(const Pieces& flat, const RestrictedDiagram& d,
                                      const Execution& execution) {
  const std::vector<CapRegion>& regions = d.caps.regions;
  if (d.caps.crossing > 0 || 2 * regions.size() != flat.piece_of_cap.size()) return std::nullopt;
  Pacer pacer(execution);
  bool is_whole = true;
  pacer.each(0, regions.size(), [&](std::size_t r) { is_whole = is_whole && regions[r].triangle_count > 0; });
  if (!is_whole) return std::nullopt;

  Pieces out{.pieces = std::vector<Piece>(flat.pieces.size()), .piece_of_cap = flat.piece_of_cap};
  parallel_for(execution, flat.pieces.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Piece& before = flat.pieces[k];
      Piece& now = out.pieces[k];
      now = {before.owners, before.part, before.island, {}, before.bodies};
      // The faces of one region are consecutive.
      std::size_t surface = 0, caps = 0;
      for (std::size_t f = 0; f < before.faces.size(); ++f) {
        const FaceSource source = before.faces[f].source;
        if (!is_cap(source))
          ++surface;
        else if (f == 0 || before.faces[f - 1].source != source)
          caps += regions[cap_region(source)].triangle_count;
      }
      execution.made(Product::kFragmentTriangles, caps);
      Pacer each(execution);
      now.faces.reserve(surface + caps);
      for (std::size_t f = 0; f < before.faces.size(); ++f) {
        each.step();
        const Face& face = before.faces[f];
        if (!is_cap(face.source)) {
          now.faces.push_back(face);
        } else if (f == 0 || before.faces[f - 1].source != face.source) {
          const CapRegion& r = regions[cap_region(face.source)];
          each.step(r.triangle_count);
          for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t) {
            const auto& v = d.caps.triangles[t];
            now.faces.push_back(cap_side(face.source) == 0 ? Face{v, face.source}
                                                           : Face{{v[0], v[2], v[1]}, face.source});
          }
        }
      }
    }
  });
  return out;
}

}  // namespace fracture
