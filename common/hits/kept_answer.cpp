#include "common/hits/kept_answer.hpp"

#include <algorithm>
#include <utility>

#include "common/base/heap_bytes.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/file_volume.hpp"
#include "common/pipeline/before_hits.hpp"

namespace fracture {

KeptUnions::KeptUnions(std::vector<Union> unions, const Execution& execution) : all(std::move(unions)) {
  for (std::uint32_t k = 0; k < all.size(); ++k)
    for (const PieceName& piece : all[k]) of_cell.emplace_back(piece.lowest, k);
  sort_with_polls(execution, of_cell.begin(), of_cell.end());
  of_cell.erase(std::unique(of_cell.begin(), of_cell.end()), of_cell.end());
}

std::size_t memory_size(const KeptCell& cell) {
  std::size_t bytes = sizeof cell + heap(cell.triangles) + heap(cell.members);
  for (const KeptFragment& kept : cell.fragments) bytes += memory_size(kept);
  return bytes;
}

std::size_t memory_size(const FracturedBase& base) {
  std::size_t bytes = sizeof base;
  for (const KeptFragment& kept : base.fragments) bytes += memory_size(kept);
  if (!base.local) return bytes;
  const LocalBase& local = *base.local;
  const FragmentFigures& f = local.figures;
  // A site has a point, a tetrahedron, a cell, and about eight bonds, half of which are stored at it.
  constexpr std::size_t kPerSite = sizeof(Vec3d) + sizeof(TetId) +
                                   2 * sizeof(std::shared_ptr<const KeptCell>) +
                                   sizeof(std::vector<KeptBond>) + 8 * sizeof(KeptBond);
  if (local.image) {
    const Solid& image = *local.image;
    bytes += heap(image.positions) + heap(image.triangles) + heap(image.edges) + heap(image.edge_vertices) +
             heap(image.shell) + heap(image.part) + heap(image.parts);
  }
  if (local.rough) bytes += heap_size(*local.rough);
  for (const KeptUnions* unions : {local.unions.get(), local.late.get()})
    bytes += heap(unions->of_cell) + nested_heap(unions->all);
  if (local.bricks) bytes += heap(*local.bricks);
  bytes += heap(local.notes.point_of_site);
  for (const auto& [id, sheet] : *local.sheets) bytes += 64 + memory_size(KeptFragment{*sheet, {}, 0});
  for (std::uint32_t k = 0; k < local.states->size(); ++k)  // as a vector, and as a key of the map
    bytes += 2 * (sizeof(std::vector<PartWinding>) + heap((*local.states)[k])) + 48;
  return bytes + kPerSite * local.cells.size() +
         (sizeof(KeptTetrahedralization::Tet) + sizeof(std::uint32_t)) * local.tetrahedra.tet_end() +
         sizeof(SiteId) * (local.label.size() + local.lowest.size()) + local.cell_bytes + heap(f.first_of) +
         heap(f.volumes) + heap(f.volumes_file) + heap(f.surface_areas) + heap(f.sorted_volumes) +
         heap(f.sorted_ids) + heap(f.sorted_excesses);
}

std::vector<std::vector<std::uint32_t>> triangles_by_cell(const Solid& solid, const SurfaceCuts& cuts,
                                                          std::size_t cells, const Execution& execution) {
  std::vector<std::vector<std::uint32_t>> result(cells);
  Pacer pacer(execution);
  std::size_t p = 0;
  for (std::uint32_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(4);
    if (p == cuts.polygons.size() || cuts.polygons[p].triangle != t)
      result[cuts.label[solid.triangles[t][0]]].push_back(t);
    for (; p < cuts.polygons.size() && cuts.polygons[p].triangle == t; ++p) {
      pacer.step(4);
      result[cuts.polygons[p].cell].push_back(t);
    }
  }
  return result;
}

void LocalBaseMaker::see(const RestrictedDiagram& restricted, const Execution& execution) {
  const Tetrahedralization& t = restricted.diagram.dual();
  box_ = restricted.seen.box;
  label_ = restricted.cuts.label;
  if (!restricted.bricks.empty())
    bricks_ = std::make_shared<const std::vector<std::uint32_t>>(restricted.bricks.begin(),
                                                                 restricted.bricks.end());
  if (restricted.diagram.map()) image_ = std::make_shared<const Solid>(restricted.seen);
  triangles_ = triangles_by_cell(restricted.seen, restricted.cuts, t.site_count(), execution);

  // Inner vertices by tetrahedron; most tetrahedra have one.
  Pacer pacer(execution);
  std::vector<std::vector<PartWinding>> several;
  struct One {
    std::uint32_t count = 0, several = kNoIndex;
    PartWinding winding{};
  };
  std::vector<One> of_tet(t.tets.size());
  for (const InnerVertex& v : restricted.winding.inner_vertices) {
    pacer.step(2);
    One& one = of_tet[v.tet];
    const PartWinding winding{v.part, v.winding};
    if (one.count++ == 0) {
      one.winding = winding;
      continue;
    }
    if (one.several == kNoIndex) {
      one.several = static_cast<std::uint32_t>(several.size());
      several.push_back({one.winding});
    }
    several[one.several].push_back(winding);
  }
  state_.assign(of_tet.size(), WindingStates::kNothing);
  PartWinding last{};
  std::uint32_t last_number = WindingStates::kNothing;
  for (std::size_t k = 0; k < of_tet.size(); ++k) {
    pacer.step();
    const One& one = of_tet[k];
    if (one.count == 0) continue;
    if (one.count > 1) {
      state_[k] = states_.number_of(several[one.several]);
      continue;
    }
    if (last_number == WindingStates::kNothing || one.winding != last) {
      last = one.winding;
      last_number = states_.number_of({last});
    }
    state_[k] = last_number;
  }
}

void LocalBaseMaker::see(CutCells& cut, bool adds_contacts) {
  if (adds_contacts) cap_bonds_ = cut.set.bonds;
  lowest_ = std::move(cut.lowest);
  pieces_ = std::move(cut.pieces);
  unions_ = std::move(cut.unions);
  late_ = std::move(cut.late);
}

std::optional<LocalBase> LocalBaseMaker::make(const FracturedSolid& answer, const Diagram& diagram,
                                              const Execution& execution) {
  std::optional<KeptTetrahedralization> tetrahedra =
      KeptTetrahedralization::of(diagram.tetrahedralization, box_, execution);
  if (!tetrahedra) return std::nullopt;
  const std::vector<Fragment>& fragments = answer.set.fragments;
  const std::uint32_t sites = diagram.tetrahedralization.site_count();
  std::vector<KeptFragment> kept;
  kept.reserve(fragments.size());
  for (std::uint32_t k = 0; k < fragments.size(); ++k) kept.push_back(kept_fragment(answer, k, execution));
  auto sheets = std::make_shared<KeptSheets>();
  for (KeptFragment& each : kept)
    if (each.fragment.sheet) sheets->emplace(each.fragment.id, std::exchange(each.fragment.sheet, nullptr));
  LocalBase base{std::move(*tetrahedra),
                 SharedBlocks<std::uint32_t, 256>(std::move(state_)),
                 std::make_shared<const WindingStates>(std::move(states_)),
                 SharedBlocks<SiteId, 256>(std::move(label_)),
                 {},
                 {},
                 {},
                 figures_of(kept, pieces_, execution),
                 diagram.map,
                 notes_of(diagram),
                 std::move(image_),
                 answer.set.size,
                 sites_of_pattern(diagram),
                 std::make_shared<const KeptUnions>(std::move(unions_), execution),
                 std::make_shared<const KeptUnions>(std::move(late_), execution)};
  base.bricks = std::move(bricks_);
  base.sheets = std::move(sheets);
  const std::vector<std::uint32_t>& first_of = base.figures.first_of;
  Pacer pacer(execution);
  std::vector<std::vector<SiteId>> members(lowest_.size());
  for (const SiteId s : ids<SiteId>(lowest_.size())) {
    pacer.step(4);
    members[lowest_[s]].push_back(s);
  }
  std::vector<std::shared_ptr<const KeptCell>> cells(sites);
  for (const SiteId s : ids<SiteId>(sites)) {
    pacer.step(16);
    KeptCell cell;
    if (!members.empty() && members[s].size() > 1) cell.members = std::move(members[s]);
    cell.pieces = pieces_[s];
    cell.fragments.assign(std::make_move_iterator(kept.begin() + first_of[s]),
                          std::make_move_iterator(kept.begin() + first_of[s + 1]));
    cell.triangles = std::move(triangles_[s]);
    base.cell_bytes += memory_size(cell);
    cells[s] = std::make_shared<const KeptCell>(std::move(cell));
  }
  std::vector<std::shared_ptr<const std::vector<KeptBond>>> bonds(sites);
  const std::vector<Bond>& all = cap_bonds_ ? *cap_bonds_ : answer.set.bonds;  // ascending by a, then b
  for (std::size_t k = 0; k < all.size();) {
    const SiteId s = fragments[all[k].a].sites[0];
    std::vector<KeptBond> of_cell;
    for (; k < all.size() && fragments[all[k].a].sites[0] == s; ++k) {
      pacer.step(8);
      const Bond& bond = all[k];
      const SiteId other = fragments[bond.b].sites[0];
      of_cell.push_back(
          {bond.a - first_of[s], other, bond.b - first_of[other], bond.area, bond.centroid, bond.normal});
    }
    if (!of_cell.empty()) bonds[s] = std::make_shared<const std::vector<KeptBond>>(std::move(of_cell));
  }
  base.cells = SharedBlocks<std::shared_ptr<const KeptCell>>(std::move(cells));
  base.lowest = SharedBlocks<SiteId, 256>(std::move(lowest_));
  base.bonds = SharedBlocks<std::shared_ptr<const std::vector<KeptBond>>>(std::move(bonds));
  return base;
}

KeptFragment kept_fragment(const FracturedSolid& answer, std::uint32_t k, const Execution& execution) {
  const Fragment& fragment = answer.set.fragments[k];
  const std::vector<FragmentHulls>& hulls = answer.hulls.of_fragment;
  return {fragment, hulls.empty() ? FragmentHulls() : hulls[k], file_volume(fragment, execution).volume};
}

Certificate certificate_of(const Solid& solid, const FragmentFigures& figures) {
  Certificate c;
  for (const double v : figures.volumes) c.volume_out += v;
  for (const double v : figures.volumes_file) c.volume_file += v;
  ProofSums sums{figures.open_edges, figures.caps, 0};
  for (const double a : figures.surface_areas) sums.surface_area += a;
  c.cells = figures.cells;
  c.fragments = static_cast<std::uint32_t>(figures.volumes.size());
  c.islands = figures.pieces - figures.cells;
  c.united = figures.pieces - c.fragments;
  sum_up(solid, sums, c);
  return c;
}

CutCells all_cells_of(const Solid& solid, const LocalBase& base, const Execution& execution) {
  CutCells cut;
  FragmentSet& set = cut.set;
  set.source = solid.source;
  const std::vector<std::uint32_t>& first_of = base.figures.first_of;
  set.fragments.reserve(first_of.back());
  cut.hulls.of_fragment.reserve(first_of.back());
  Pacer pacer(execution);
  for (std::uint32_t s = 0; s < base.cells.size(); ++s) {
    pacer.step(8);
    for (const KeptFragment& kept : base.cells[s]->fragments) {
      pacer.step(8 + kept.fragment.indices.size() / 64);
      set.fragments.push_back(kept.fragment);
      cut.hulls.of_fragment.push_back(kept.hulls);
    }
    if (!base.bonds[s]) continue;
    for (const KeptBond& bond : *base.bonds[s])
      set.bonds.push_back({first_of[s] + bond.fragment, first_of[bond.other_cell] + bond.other_fragment,
                           bond.area, bond.centroid, bond.normal});
  }
  set.certificate = certificate_of(solid, base.figures);
  set.size = base.size;
  if (base.rough) cut.rough = base.rough->report;
  state_lattice(solid, set);
  return cut;
}

}  // namespace fracture
