#include "common/pipeline/cut_again.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/contacts/contacts.hpp"
#include "common/fragment/carried_sheets.hpp"
#include "common/fragment/fragment_solid.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/fragment/mirror_sum.hpp"
#include "common/fragment/sheet_mesh.hpp"
#include "common/fragment/unite.hpp"
#include "common/physics/aggregate_hulls.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/local_impact.hpp"
#include "common/pipeline/part_contacts.hpp"
#include "common/pipeline/rough_cells.hpp"
#include "common/pipeline/soundness.hpp"
#include "common/solid/sheet_surface.hpp"

namespace fracture {
namespace {

/// Whether two owners share a cut, or a triangle of the surface. (A cut without area may have no region.)
bool is_cut(const RestrictedDiagram& restricted, const Ownership& ownership) {
  const auto owner = [&](SiteId s) { return ownership.owner_of_site[s]; };
  const std::vector<CutPolygon>& polygons = restricted.cuts.polygons;
  for (std::size_t k = 1; k < polygons.size(); ++k)
    if (polygons[k].triangle == polygons[k - 1].triangle &&
        owner(polygons[k].cell) != owner(polygons[k - 1].cell))
      return true;
  return std::any_of(restricted.caps.regions.begin(), restricted.caps.regions.end(),
                     [&](const CapRegion& r) { return owner(r.lo) != owner(r.hi); });
}

/// Pieces that stay together because they touch across parts in one cell.
std::vector<Union> unions_across(const RestrictedDiagram& flat, const Ownership& ownership,
                                 const FractureParameters& parameters, const Execution& execution) {
  if (flat.solid.parts.size() < 2 || !joins_parts(flat.solid, parameters)) return {};
  const Pieces pieces = gather_pieces(flat, ownership, execution);
  const std::optional<PartContacts> across =
      find_part_contacts(flat, ownership, pieces, parameters, execution);
  PieceGroups groups(pieces.pieces.size());
  unite_by_size(flat, pieces, {}, across ? &*across : nullptr, groups, execution);
  return name_unions(flat, pieces, groups, lowest_cells(ownership), execution);
}

/// Adds the triangles that were caps before the hit to the caps.
void merge_caps(Fragment& f) {
  f.caps.insert(f.caps.end(), f.earlier_caps.begin(), f.earlier_caps.end());
  std::sort(f.caps.begin(), f.caps.end(),
            [](const IndexRange& a, const IndexRange& b) { return a.first < b.first; });
  f.surface_area -= f.earlier_cap_area;
  f.earlier_caps.clear();
  f.earlier_cap_area = 0;
}

/// The fragment's volume before rounding, relative to that of its rounded surface, from which the pieces are cut. Their
/// volumes are scaled by it, so that they add up to the fragment's volume. 1 if one of the two is not positive.
double scale_of_volumes(const Fragment& from, const Solid& rounded) {
  const double before = from.mass.volume, after = rounded.report.volume;
  return before > 0 && after > 0 ? before / after : 1;
}

void scale_volumes(double scale, Fragment& f) {
  f.mass.volume *= scale;
  for (double& moment : f.mass.inertia) moment *= scale;
  for (PartVolume& of_part : f.part_volumes) of_part.volume *= scale;
}

/// Depends on the coordinates of the sites and on the parts.
std::uint64_t name_of(const Fragment& f, const HitCells& cells) {
  std::uint64_t h = 0x686974ull;
  for (const SiteId s : f.sites)
    for (int axis = 0; axis < 3; ++axis)
      h = mix64(h, std::bit_cast<std::uint64_t>(cells.dual.points[s][axis] + 0.0));
  h = mix64(h, f.part);
  for (const PartCell& cell : f.part_cells) h = mix64(h, cell.part);
  return h;
}

/// Replaces the sites of the hit by those of the fragment, of which the piece is an island.
void take_sites(const Fragment& from, Fragment& f) {
  f.source_part = from.part_cells.empty() ? from.source_part : f.part;
  std::vector<std::uint32_t> parts{f.part};
  for (const PartCell& cell : f.part_cells) parts.push_back(cell.part);
  f.part_cells.clear();
  f.sites = from.sites;
  if (from.part_cells.empty()) return;
  f.sites.clear();
  for (const PartCell& cell : from.part_cells) {
    if (std::find(parts.begin(), parts.end(), cell.part) == parts.end()) continue;
    f.sites.push_back(cell.site);
    if (parts.size() > 1) f.part_cells.push_back(cell);
  }
  std::sort(f.sites.begin(), f.sites.end());
  f.sites.erase(std::unique(f.sites.begin(), f.sites.end()), f.sites.end());
}

/// The part of `hull` within `within`, which is in a frame whose origin is at `shift`.
CollisionHull common_of(CollisionHull hull, const CollisionHull& within, const Vec3d& shift,
                        const Execution& execution) {
  for (const auto& t : within.triangles) {
    const auto at = [&](int k) { return to_double(within.points[t[static_cast<std::size_t>(k)]]) + shift; };
    const Vec3d a = at(0), n = cross(at(1) - a, at(2) - a);
    const double l = length(n);
    if (!(l > 0)) continue;
    const Vec3d normal = (1 / l) * n;
    const double offset = dot(normal, a);
    const bool reaches_out = std::any_of(hull.points.begin(), hull.points.end(),
                                         [&](const Vec3f& p) { return dot(normal, to_double(p)) > offset; });
    if (reaches_out) hull = trimmed(hull, normal, offset, execution);
    if (hull.triangles.empty()) return hull;
  }
  return hull;
}

/// Keeps the hulls of a piece in those of the fragment, which no hull of another fragment enters.
void keep_within(const KeptFragment& from, KeptFragment& piece, const Execution& execution) {
  const Vec3d shift = from.fragment.pivot - piece.fragment.pivot;
  std::vector<CollisionHull> hulls;
  for (const CollisionHull& hull : piece.hulls.hulls)
    for (const CollisionHull& within : from.hulls.hulls) {
      execution.poll();
      CollisionHull common = common_of(hull, within, shift, execution);
      if (!common.triangles.empty()) hulls.push_back(std::move(common));
    }
  if (!hulls.empty()) piece.hulls.hulls = std::move(hulls);
}

/// Cuts the sheets of a fragment by the cells of the hit. Its pieces, which still have sites of the hit, carry them.
void carry_sheets_on(const HitOnFragments& hit, const Fragment& from, Solid& solid, PiecesOfFragment& out,
                     const Execution& execution) {
  FragmentSet set;
  set.source = hit.solid.source;
  const auto mesh = std::make_shared<const Mesh>(mesh_of_sheet(set, from, execution));
  std::vector<std::uint32_t> triangles(mesh->triangles.size());
  std::iota(triangles.begin(), triangles.end(), 0u);
  solid.sheets = make_sheets(mesh, triangles, hit.solid.box, /*whole=*/false, execution);
  for (KeptFragment& piece : out.pieces) set.fragments.push_back(std::move(piece.fragment));
  carry_sheets(solid, hit.diagram, hit.cells.image, set, execution);
  for (std::size_t k = 0; k < out.pieces.size(); ++k) out.pieces[k].fragment = std::move(set.fragments[k]);
  out.certificate.sheet_area_in = set.certificate.sheet_area_in;
  out.certificate.sheet_area_out = set.certificate.sheet_area_out;
}

/// Limit for pieces that hits break off, as a share of the limit for all pieces relative to the mean: such pieces are
/// small compared with the mean, but must remain.
constexpr double kShareBesideHits = 0.01;

}  // namespace

SizeLimits limits_of_hits(const FractureParameters& parameters, double volume) {
  const SizeLimits& all = parameters.size;
  SizeLimits limits;
  limits.min_volume =
      std::max({all.min_volume, all.min_fraction * volume,
                kShareBesideHits * all.min_of_mean * volume / std::max(1u, parameters.sites)});
  return limits;
}

Expected<std::optional<PiecesOfFragment>> cut_again(const HitOnFragments& hit, const KeptFragment& kept,
                                                    const Execution& execution) {
  FragmentSolid made = solid_of_fragment(kept.fragment, kept.world(), hit.solid, execution);
  Solid& solid = made.solid;
  if (solid.parts.size() > 1 && hit.solid.contacts) keep_contacts(solid, hit.solid.contacts->gap, execution);
  const SeenSolid seen(solid, hit.cells.map, execution);
  RestrictedDiagram restricted = restrict_to_solid(seen, hit.diagram, execution);
  restricted.part_in_whole = &made.parts;
  const std::vector<std::uint32_t>& groups = hit.cells.groups;
  const Ownership ownership = Ownership::from_groups(hit.cells.dual.site_count(), groups, execution);
  if (!is_cut(restricted, ownership)) return std::nullopt;

  FractureParameters parameters = hit.parameters;
  parameters.pivot = Pivot::kSource;
  CutCells cut;
  const auto judged = [&](const FragmentSet& set) { return judge(set, solid, Promise::kPartition); };
  make_rough_fragments(restricted, parameters, hit.limits, ownership, /*always=*/hit.cells.flat,
                       unions_across(restricted, ownership, parameters, execution), judged, execution, cut);
  if (const Verdict verdict = judged(cut.set); !verdict.sound())
    return tl::unexpected(unsound(verdict, cut.set.certificate));

  PiecesOfFragment out;
  out.bonds = std::move(cut.set.bonds);
  out.certificate = cut.set.certificate;
  out.size = cut.set.size;
  out.rough = cut.rough;
  out.restrained_cells = cut.restrained_cells;
  out.all_flat = cut.all_flat;
  const double scale = scale_of_volumes(kept.fragment, solid);
  Pacer pacer(execution);
  for (Fragment& f : cut.set.fragments) {
    pacer.step(64);
    out.is_rest.push_back(
        std::any_of(f.sites.begin(), f.sites.end(), [&](SiteId s) { return groups[s] == 0; }));
    out.names.push_back(name_of(f, hit.cells));
    scale_volumes(scale, f);  // first, because the excess of its hulls is relative to its volume
    out.pieces.push_back(kept_with_pivot(std::move(f), hit.parameters.pivot, execution));
  }
  if (hit.parameters.hulls == Hulls::kConvex) {
    FragmentSet& set = cut.set;
    for (std::size_t k = 0; k < out.pieces.size(); ++k) set.fragments[k] = std::move(out.pieces[k].fragment);
    const HullLimits& limits = hit.parameters.hull_limits;
    // Next to a region to keep, each site of the hit has a companion, which is a further cell of the rest.
    const std::size_t most_of_rest = hit.parameters.keep ? guard_directions().size() : SIZE_MAX;
    CollisionHulls hulls = make_collision_hulls(
        set,
        // The rest of a whole part has a hull for each guard's cell, which follow its shape.
        make_aggregate_hulls(set, hit.diagram, limits, /*cells=*/1, hit.parameters.rest == LocalRest::kWhole,
                             execution, most_of_rest),
        limits, execution);
    for (std::size_t k = 0; k < out.pieces.size(); ++k) {
      out.pieces[k].fragment = std::move(set.fragments[k]);
      out.pieces[k].hulls = std::move(hulls.of_fragment[k]);
      if (!kept.is_in_convex) keep_within(kept, out.pieces[k], execution);
    }
  }
  if (kept.fragment.sheet) carry_sheets_on(hit, kept.fragment, solid, out, execution);
  for (KeptFragment& piece : out.pieces) {
    pacer.step(64);
    Fragment& f = piece.fragment;
    piece.is_in_convex = piece.is_in_convex && kept.is_in_convex;
    out.earlier_caps.push_back(f.earlier_caps);
    merge_caps(f);
    f.cap_sum = mirror_sum(f, execution);
    take_sites(kept.fragment, f);
  }
  return out;
}

}  // namespace fracture
