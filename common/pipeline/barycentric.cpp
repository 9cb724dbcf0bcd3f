#include "common/pipeline/barycentric.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/clip/caps.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/pipeline/restrict.hpp"
#include "common/voronoi/barycentric_cell.hpp"

namespace fracture {
namespace {

/// solid ∩ the Voronoi cell of sites[0]; nothing when they do not meet.
std::optional<FragmentSet> cut_one_cell(const Solid& solid, const std::vector<Vec3d>& sites, Pivot pivot,
                                        const Execution& execution) {
  const Expected<Tetrahedralization> t = tetrahedralize(sites, solid.box, execution);
  if (!t || t->site_of_input[0] == kNoSite) return std::nullopt;
  const VoronoiDiagram cell(*t, solid.box);
  const RestrictedDiagram restricted = restrict_to_solid(solid, solid, cell, execution);
  Ownership ownership = Ownership::from_groups(t->site_count(), {});
  ownership.wanted.assign(t->site_count(), false);
  ownership.wanted[t->site_of_input[0]] = true;
  return make_fragments(restricted, ownership, pivot, {}, execution);
}

}  // namespace

BarycentricResult fracture_barycentric(const Solid& solid, const VoronoiDiagram& diagram, Pivot pivot,
                                       double drop_above, const Execution& execution) {
  const std::uint32_t sites = diagram.dual().site_count();
  std::vector<std::optional<FragmentSet>> cells(sites);
  std::vector<char> skipped(sites, 0);
  Execution single = execution;
  single.threads = 1;
  single.progress = nullptr;
  parallel_for(execution, sites, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto mirrored = barycentric_cell(diagram, static_cast<SiteId>(i));
      if (mirrored)
        cells[i] = cut_one_cell(solid, *mirrored, pivot, single);
      else
        skipped[i] = 1;
    }
  });

  BarycentricResult out;
  out.set.source = solid.source;
  Certificate& total = out.set.certificate;
  for (SiteId i = 0; i < sites; ++i) {
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
