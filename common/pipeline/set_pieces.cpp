#include "common/pipeline/set_pieces.hpp"

#include <algorithm>
#include <utility>

#include "common/fragment/make_fragments.hpp"

namespace fracture {
namespace {

/// Gives the pieces of a set the numbers of the whole.
void renumber(CutCells& cut, const std::vector<std::uint32_t>& parts, std::uint32_t first_site,
              Pacer& pacer) {
  const auto site = [&](SiteId s) { return SiteId{s + first_site}; };
  for (Fragment& f : cut.set.fragments) {
    pacer.step(4 + f.sites.size() + f.part_cells.size());
    for (SiteId& s : f.sites) s = site(s);
    f.part = parts[f.part];
    f.source_part = f.part;
    for (PartCell& cell : f.part_cells) cell = {parts[cell.part], site(cell.site)};
    for (PartVolume& volume : f.part_volumes) volume.part = parts[volume.part];
    for (std::uint32_t& part : f.triangle_parts) part = parts[part];
    for (FragmentPrimitive& p : f.primitives)
      if (p.part != kNoIndex) p.part = parts[p.part];
  }
}

void add(const RoughReport& own, RoughReport& all) {
  all.amplitude = std::max(all.amplitude, own.amplitude);
  all.asked = std::max(all.asked, own.asked);
  all.length =
      all.length > 0 && own.length > 0 ? std::min(all.length, own.length) : std::max(all.length, own.length);
  all.triangles += own.triangles;
  all.calmed += own.calmed;
  all.crossing += own.crossing;
  all.given_up = all.given_up || own.given_up;
}

void add(const Certificate& own, Certificate& all) {
  all.volume_out += own.volume_out;
  all.volume_file += own.volume_file;
  all.pocket_volume += own.pocket_volume;
  all.pocket_area += own.pocket_area;
  all.cells += own.cells;
  all.islands += own.islands;
  all.united += own.united;
  all.dropped += own.dropped;
  all.fragments += own.fragments;
  all.crossing_caps += own.crossing_caps;
  all.sheet_area_in += own.sheet_area_in;
  all.sheet_area_out += own.sheet_area_out;
}

void add(const SizeFigures& own, SizeFigures& all) {
  all.united += own.united;
  all.inside_out += own.inside_out;
  all.alone += own.alone;
  all.parts += own.parts;
  all.min_volume = std::max(all.min_volume, own.min_volume);
  all.fewest_triangles += own.fewest_triangles;
}

}  // namespace

void SetPieces::add_set(CutCells cut, const std::vector<std::uint32_t>& parts, std::uint32_t first_site) {
  renumber(cut, parts, first_site, pacer_);
  const auto first = static_cast<std::uint32_t>(all_.set.fragments.size());
  for (Fragment& f : cut.set.fragments) {
    pacer_.step(4);
    while (!ids_.insert(f.id).second) f.id = (f.id + 1) & ((1ull << 53) - 1);  // a set numbers its own parts
    all_.set.fragments.push_back(std::move(f));
  }
  for (Bond bond : cut.set.bonds) {
    pacer_.step();
    bond.a += first;
    bond.b += first;
    all_.set.bonds.push_back(bond);
  }
  if (!cut.hulls.of_fragment.empty()) all_.hulls.of_fragment.resize(first);
  for (FragmentHulls& hulls : cut.hulls.of_fragment) all_.hulls.of_fragment.push_back(std::move(hulls));
  add(cut.set.certificate, all_.set.certificate);
  add(cut.set.size, all_.set.size);
  add(cut.rough, all_.rough);
  all_.kept += cut.kept;
  all_.grouped = all_.grouped || cut.grouped;
  all_.restrained_cells += cut.restrained_cells;
  all_.all_flat = all_.all_flat || cut.all_flat;
  all_.barycentric.skipped_hulls += cut.barycentric.skipped_hulls;
  all_.barycentric.dropped += cut.barycentric.dropped;
  all_.barycentric.dropped_volume += cut.barycentric.dropped_volume;
}

CutCells SetPieces::finish(const Solid& solid) {
  FragmentSet& set = all_.set;
  set.source = solid.source;
  if (!all_.hulls.of_fragment.empty()) all_.hulls.of_fragment.resize(set.fragments.size());
  state_lattice(solid, set);  // no finer than those of the sets
  sum_up(solid, set.fragments, set.certificate);
  return std::move(all_);
}

}  // namespace fracture
