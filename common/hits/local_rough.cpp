#include "common/hits/local_rough.hpp"

#include <algorithm>
#include <utility>

#include "common/base/heap_bytes.hpp"
#include "common/base/pacer.hpp"
#include "common/rough/moving_caps.hpp"

namespace fracture {
namespace {

using Cuts = std::vector<std::shared_ptr<const KeptCut>>;

bool contains(std::span<const SiteId> sites, SiteId s) {
  return std::binary_search(sites.begin(), sites.end(), s);
}

CellCuts gathered(Cuts cuts) {
  CellCuts out;
  if (cuts.empty()) return out;
  for (const auto& cut : cuts) out.box.add(cut->box);
  out.cuts = std::make_shared<const Cuts>(std::move(cuts));
  return out;
}

/// Moves the cuts of one cell out of a trace, in which they are ascending by lo.
void take_cuts(std::vector<KeptCut>& all, std::size_t& next, SiteId lo, std::size_t& bytes, Cuts& out) {
  for (; next < all.size() && all[next].lo == lo; ++next) {
    bytes += memory_size(all[next]);
    out.push_back(std::make_shared<const KeptCut>(std::move(all[next])));
  }
}

}  // namespace

std::size_t heap_size(const LocalRough& rough) {
  // A pointer and its count for each cut, about seven per cell.
  constexpr std::size_t kPerSite =
      sizeof(CellCuts) + sizeof(Cuts) + 7 * 2 * sizeof(std::shared_ptr<const KeptCut>);
  return rough.cut_bytes + kPerSite * rough.cuts.size() + heap(*rough.calmings);
}

LocalRough keep_cuts(RoughTrace trace, const RoughReport& report, std::uint32_t sites,
                     const Execution& execution) {
  LocalRough out;
  out.report = report;
  out.pairs = trace.pairs;
  out.area = trace.area;
  out.edges = trace.edges;
  out.calmings = std::make_shared<const std::vector<Calming>>(std::move(trace.calmings));
  std::vector<CellCuts> of_cell(sites);
  Pacer pacer(execution);
  std::size_t next = 0;
  for (const SiteId s : ids<SiteId>(sites)) {
    Cuts cuts;
    take_cuts(trace.cuts, next, s, out.cut_bytes, cuts);
    pacer.step(4 + 16 * cuts.size());
    of_cell[s] = gathered(std::move(cuts));
  }
  out.cuts = SharedBlocks<CellCuts>(std::move(of_cell));
  return out;
}

std::vector<const KeptCut*> cuts_near(const LocalRough& rough, std::vector<Box> boxes,
                                      std::span<const SiteId> made, const SeamLattice& lattice,
                                      const Execution& execution) {
  Pacer pacer(execution);
  for (const Calming& calming : *rough.calmings) {
    pacer.step(8);
    const bool by_made =
        std::any_of(calming.cells.begin(), calming.cells.end(), [&](SiteId s) { return contains(made, s); });
    if (!by_made) continue;
    const Vec3d p = lattice.to_world(calming.place);
    boxes.push_back({p, p});
  }
  Box all;
  for (const Box& box : boxes) all.add(box);
  const BoxTree tree(boxes, execution);
  std::vector<const KeptCut*> near;
  for (const SiteId s : ids<SiteId>(rough.cuts.size())) {
    const CellCuts& of_cell = rough.cuts[s];
    pacer.step();
    if (!of_cell.cuts || !of_cell.box.intersects(all) || contains(made, s)) continue;
    for (const auto& cut : *of_cell.cuts) {
      pacer.step(16);
      if (contains(made, cut->hi)) continue;
      bool meets = false;
      tree.each_overlapping(cut->box, [&](std::uint32_t) { meets = true; });
      if (meets) near.push_back(cut.get());
    }
  }
  return near;
}

std::optional<LocalRough> replace_cuts(const LocalRough& before, RoughPart part, std::span<const SiteId> made,
                                       std::span<const SiteId> around, std::uint32_t sites,
                                       const Execution& execution) {
  LocalRough out = before;
  Pacer pacer(execution);
  std::vector<Calming> stay, calmings;
  for (const Calming& calming : *before.calmings) {
    pacer.step(8);
    if (std::none_of(calming.cells.begin(), calming.cells.end(), [&](SiteId s) { return contains(made, s); }))
      stay.push_back(calming);
  }
  std::set_union(stay.begin(), stay.end(), part.trace.calmings.begin(), part.trace.calmings.end(),
                 std::back_inserter(calmings));
  if (calmings.size() > MovingCaps::kMostCalmings) return std::nullopt;
  out.report.calmed = places_of(calmings);
  out.calmings = std::make_shared<const std::vector<Calming>>(std::move(calmings));
  out.pairs += part.trace.pairs;
  out.area = part.trace.area;
  out.edges = part.trace.edges;

  SharedBlocks<CellCuts>::Edit edit(out.cuts);
  for (std::size_t n = before.cuts.size(); n < sites; ++n) edit.push_back({});
  std::size_t next = 0;
  for (const SiteId s : around) {
    Cuts cuts;
    bool same = true;
    if (s < before.cuts.size() && before.cuts[s].cuts)
      for (const auto& cut : *before.cuts[s].cuts) {
        pacer.step(8);
        if (!contains(made, s) && !contains(made, cut->hi)) {
          cuts.push_back(cut);
          continue;
        }
        same = false;
        out.report.triangles -= cut->triangles.size();
        out.cut_bytes -= memory_size(*cut);
      }
    const std::size_t stayed = cuts.size();
    take_cuts(part.trace.cuts, next, s, out.cut_bytes, cuts);
    for (std::size_t k = stayed; k < cuts.size(); ++k) out.report.triangles += cuts[k]->triangles.size();
    pacer.step(4 + 16 * cuts.size());
    if (!same || cuts.size() > stayed) edit.at(s) = gathered(std::move(cuts));
  }
  if (next < part.trace.cuts.size()) throw InternalError("a cut of cells outside of the part");
  if (out.pairs > Crossings::kMostPairs * out.report.triangles) return std::nullopt;
  return out;
}

}  // namespace fracture
