#include "common/pipeline/barycentric.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/pacer.hpp"
#include "common/clip/caps.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/pipeline/cell_patch.hpp"
#include "common/voronoi/barycentric_cell.hpp"

namespace fracture {
namespace {

/// Returns solid ∩ the Voronoi cell of sites[0], or nothing if they do not meet.
std::optional<FragmentSet> cut_one_cell(const Solid& solid, const PatchFinder& finder,
                                        const std::vector<Vec3d>& sites, Pivot pivot,
                                        const Execution& execution, std::uint64_t& looked_at) {
  // Only the fragments are kept. Everything that earlier steps make is freed with the cell.
  Execution uncounted = execution;
  uncounted.allowance = nullptr;
  const Expected<Tetrahedralization> t = tetrahedralize(sites, solid.box, uncounted);
  if (!t || t->site_of_input[0] == kNoSite) return std::nullopt;
  const SiteId cell = t->site_of_input[0];
  const VoronoiDiagram diagram(*t, solid.box, {}, execution);
  CellPatch patch = finder.around(diagram, cell, uncounted);
  looked_at = patch.looked_at;
  if (patch.empty()) return std::nullopt;

  std::vector<char> wanted(t->site_count(), 0);
  wanted[cell] = 1;
  const Solid& surface = patch.surface.solid;
  RestrictedDiagram r{surface, surface, diagram, cut_surface(surface, diagram, uncounted)};
  r.part_in_whole = &patch.surface.parts;
  r.winding =
      wind_voronoi_edges_of(surface, diagram, r.cuts, {wanted, patch.seed, patch.seed_winding}, uncounted);
  r.place_and_cap(uncounted, &wanted);
  Ownership ownership = Ownership::from_groups(t->site_count(), {});
  ownership.wanted.assign(wanted.begin(), wanted.end());
  return make_fragments(r, ownership, pivot, {}, execution);
}

}  // namespace

BarycentricResult fracture_barycentric(const Solid& solid, const VoronoiDiagram& diagram, Pivot pivot,
                                       double drop_above, const Execution& execution) {
  const std::uint32_t sites = diagram.dual().site_count();
  std::vector<std::optional<FragmentSet>> cells(sites);
  std::vector<char> skipped(sites, 0);
  std::vector<std::uint64_t> looked_at(sites, 0);
  const PatchFinder finder(solid, execution);
  Execution single = execution;
  single.threads = 1;
  single.progress = nullptr;
  single.within = nullptr;
  parallel_for(execution, sites, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto mirrored = barycentric_cell(diagram, SiteId{i});
      if (mirrored)
        cells[i] = cut_one_cell(solid, finder, *mirrored, pivot, single, looked_at[i]);
      else
        skipped[i] = 1;
    }
  });

  BarycentricResult out;
  out.set.source = solid.source;
  Certificate& total = out.set.certificate;
  Pacer pacer(execution);
  for (const SiteId i : ids<SiteId>(sites)) {
    pacer.step();
    out.looked_at += looked_at[i];
    out.skipped_hulls += static_cast<std::uint32_t>(skipped[i]);
    if (!cells[i]) continue;
    if (const double volume = cells[i]->certificate.volume_out; drop_above > 0 && volume > drop_above) {
      ++out.dropped;
      out.dropped_volume += volume;
      continue;
    }
    const Certificate& c = cells[i]->certificate;
    total.open_edges += c.open_edges;
    total.volume_out += c.volume_out;
    total.volume_file += c.volume_file;
    total.cells += c.cells;
    total.islands += c.islands;
    total.dropped += c.dropped;
    total.crossing_caps += c.crossing_caps;
    for (Fragment& f : cells[i]->fragments) {
      f.sites = {i};
      out.set.fragments.push_back(std::move(f));
    }
    out.set.lattice_step = cells[i]->lattice_step;
    out.set.lattice_ratio = cells[i]->lattice_ratio;
  }
  total.volume_in = solid.report.volume;
  total.relative_error = std::fabs(total.volume_out - total.volume_in) / total.volume_in;
  total.fragments = static_cast<std::uint32_t>(out.set.fragments.size());
  return out;
}

}  // namespace fracture
