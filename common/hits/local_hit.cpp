#include "common/hits/local_hit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/id_table.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/pieces.hpp"
#include "common/hits/difference.hpp"
#include "common/hits/hit_area.hpp"
#include "common/physics/aggregate_hulls.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/aggregate.hpp"
#include "common/solid/patch.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {
namespace {

/// Maximum shares of all cells that are made again with rough cuts: in one try, and in all tries together.
constexpr double kMostOfCells = 0.75, kMostInAllTries = 1.1;

class LocalHit {
 public:
  /// `further`: more cells to make again; cells that should have been included are added. `made`: number of
  /// cells made in earlier tries.
  LocalHit(const Solid& solid, const LocalBase& base, const FractureParameters& parameters,
           std::vector<SiteId>& further, std::size_t& made, const Execution& execution)
      : solid_(solid),
        base_(base),
        parameters_(parameters),
        further_(further),
        made_in_all_(made),
        execution_(execution),
        limits_(limits_in_force(parameters, solid.report.volume, base.pattern_sites)),
        pacer_(execution),
        out_{base} {}

  std::optional<HitOutcome> run(std::span<const Vec3d> points, std::span<const std::uint32_t> groups) {
    std::optional<KeptTetrahedralization::Insertion> inserted = now().insert(points, execution_);
    if (!inserted) return std::nullopt;
    number_points(*inserted, points.size());
    SiteFigures& sites = out_.next.notes.figures;
    sites.given += points.size();
    sites.used = now().site_count();
    sites.duplicates_merged = now().duplicates_merged();
    if (inserted->made.empty()) return keeps_to_limits() ? std::optional(std::move(out_)) : std::nullopt;
    area_.emplace(base_, out_.next, *inserted, groups, further_, solid_.triangles.size(), execution_);
    // If most cells were made again, perhaps in vain, and then the whole, this would cost more than making
    // only the whole. The second try usually succeeds.
    made_in_all_ += area_->wanted().size();
    const double cells = now().site_count();
    if (base_.rough && (static_cast<double>(area_->wanted().size()) > kMostOfCells * cells ||
                        static_cast<double>(made_in_all_) > kMostInAllTries * cells))
      return std::nullopt;
    // A union that the hit takes apart leaves pieces that are too small, and these limits also apply near hits.
    if ((parameters_.size.min_volume > 0 || parameters_.size.min_fraction > 0) && area_->takes_unions_apart())
      return std::nullopt;
    if (!make_fragments(inserted->made) || !others_are_as_they_were()) return std::nullopt;
    replace_cells();
    replace_late_unions();
    if (!sum_up_again() || !keeps_to_limits()) return std::nullopt;
    replace_bonds();
    replace_surface();
    replace_states(inserted->made);
    out_.around = area_->owners();
    return std::move(out_);
  }

 private:
  /// Records which points the new sites came from.
  void number_points(const KeptTetrahedralization::Insertion& inserted, std::size_t given) {
    std::vector<std::uint32_t>& point_of_site = out_.next.notes.point_of_site;
    if (point_of_site.empty() && inserted.points.size() == given) return;
    const std::size_t before = now().site_count() - inserted.points.size();
    while (point_of_site.size() < before)
      point_of_site.push_back(static_cast<std::uint32_t>(point_of_site.size()));
    for (const std::uint32_t k : inserted.points)
      point_of_site.push_back(static_cast<std::uint32_t>(base_.notes.figures.given + k));
  }

  KeptTetrahedralization& now() { return out_.next.tetrahedra; }
  const KeptTetrahedralization::Part& part() const { return area_->part(); }

  /// Number of fragments of a wanted cell and the cells that stay together with it, all stored at the lowest.
  std::uint32_t fragments_made(SiteId s) const {
    if (!area_->is_owner(s)) return 0;
    const std::uint32_t owner = area_->number_of(s);
    return made_.first_of[owner + 1] - made_.first_of[owner];
  }

  /// Finds the part's Voronoi vertices that existed before, with the winding numbers of parts around them.
  void find_known(const std::vector<TetId>& made) {
    IdTable is_made;
    for (const TetId t : made) is_made.slot(t) = 1;
    for (const TetId t : ids<TetId>(part().tets.size())) {
      pacer_.step(2);
      if (is_made.find(part().tets[t]) != IdTable::kEmpty) continue;
      const auto index = static_cast<std::uint32_t>(known_.size());
      known_.push_back(t);
      for (const PartWinding& w : (*base_.states)[base_.state[part().tets[t]]])
        known_windings_.push_back({TetId{index}, w.part, w.winding});
    }
  }

  /// Returns false if pieces without volume were left out, or if caps cross.
  bool make_fragments(const std::vector<TetId>& made) {
    find_known(made);
    std::vector<std::uint32_t> parts;
    for (const InnerVertex& v : known_windings_)
      if (parts.empty() || parts.back() != v.part) parts.push_back(v.part);
    surface_ = patch_of(solid_, area_->triangles(), parts, execution_);
    std::optional<SolidPatch> image;
    if (base_.image) image = patch_of(*base_.image, surface_.triangles, parts, execution_);
    const Solid& seen = image ? image->solid : surface_.solid;
    for (InnerVertex& v : known_windings_) v.part = surface_.local_part(v.part);
    const std::uint32_t sites = part().tetrahedra.site_count();
    std::vector<char> wanted(sites, 0);
    for (const SiteId s : area_->wanted()) wanted[part().local(s)] = 1;
    const VoronoiDiagram diagram(part().tetrahedra, part().whole, seen.box, base_.map, execution_);
    VoronoiDiagram::Walk walk;
    std::vector<SiteId> label;
    for (std::size_t v = 0; v < surface_.vertices.size(); ++v) {
      const std::uint64_t looked_at = walk.looked_at;
      label.push_back(part().local(base_.label[surface_.vertices[v]]));
      if (wanted[label[v]]) label[v] = diagram.nearest(to_double(seen.positions[v]), label[v], walk);
      pacer_.step(8 + walk.looked_at - looked_at);
    }
    RestrictedDiagram r{surface_.solid, seen, diagram,
                        cut_surface(seen, diagram, std::move(label), execution_)};
    r.part_in_whole = &surface_.parts;
    std::vector<std::uint32_t> bricks;
    if (base_.bricks)
      for (const SiteId s : part().sites)
        bricks.push_back(s < base_.bricks->size() ? (*base_.bricks)[s] : kNoIndex);
    r.bricks = bricks;
    r.winding = wind_voronoi_edges_of(seen, diagram, r.cuts, {wanted, known_, known_windings_}, execution_);
    r.place_and_cap(execution_, &wanted);
    const Ownership ownership = area_->ownership();
    if (base_.rough && !roughen(r, ownership.owner_of_site)) return false;

    const std::vector<SiteId>& owners = area_->owners();
    OwnersInWhole whole{owners, std::vector<std::uint32_t>(owners.size(), 0)};
    for (std::size_t o = 0; o < owners.size(); ++o)
      if (!ownership.wanted[o]) whole.others[o] = area_->fragments_before(owners[o]);
    std::vector<Union> before = area_->active_unions(ownership);
    for (Union& late : area_->lasting_late_unions()) before.push_back(std::move(late));
    std::optional<WantedFragments> result =
        make_wanted_fragments(r, ownership, whole, before, limits_.min_volume, parameters_.pivot, execution_);
    if (!result || result->crossing_caps > 0 || !late_unions_change(*result)) return false;
    made_ = std::move(*result);
    make_hulls_of_aggregates(diagram);
    for (Fragment& f : made_.fragments) {
      for (SiteId& s : f.sites) s = part().sites[s];
      for (PartCell& cell : f.part_cells) cell.site = part().sites[cell.site];
    }

    triangles_by_cell_ = triangles_by_cell(surface_.solid, r.cuts, sites, execution_);
    label_ = std::move(r.cuts.label);
    inner_vertices_ = std::move(r.winding.inner_vertices);
    return true;
  }

  /// Pieces that are too small unite with cells that change too. Returns false if other cells are involved.
  bool late_unions_change(const WantedFragments& made) {
    const std::size_t before = further_.size();
    further_.insert(further_.end(), made.further.begin(), made.further.end());
    for (const Union& pieces : made.late)
      for (const PieceName& piece : pieces)
        if (!area_->changes(piece.lowest)) further_.push_back(piece.lowest);
    return further_.size() == before;
  }

  void make_hulls_of_aggregates(const VoronoiDiagram& diagram) {
    if (parameters_.hulls != Hulls::kConvex) return;
    FragmentSet set;
    set.fragments.swap(made_.fragments);
    hulls_ =
        make_aggregate_hulls(set, diagram, parameters_.hull_limits.count, cells_per_fragment(parameters_),
                             /*has_rest=*/false, execution_);
    set.fragments.swap(made_.fragments);
  }

  bool roughen(RestrictedDiagram& r, const std::vector<std::uint32_t>& owners) {
    const LocalRough& before = *base_.rough;
    const SeamLattice lattice = r.positions.lattice;
    std::optional<RoughPart> rough =
        roughen_part(r, owners, parameters_.roughness, parameters_.seed,
                     {solid_, part().sites, area_->wanted(), before.area, before.edges, *before.calmings,
                      [&](std::vector<Box> boxes) {
                        return cuts_near(before, std::move(boxes), area_->wanted(), lattice, execution_);
                      }},
                     execution_);
    if (!rough) return false;
    further_.insert(further_.end(), rough->spread.begin(), rough->spread.end());
    if (!rough->spread.empty()) return false;
    std::optional<LocalRough> after = replace_cuts(before, std::move(*rough), area_->wanted(), part().sites,
                                                   now().site_count(), execution_);
    if (!after) return false;
    out_.next.rough = std::move(*after);
    return true;
  }

  /// Returns false if other cells that were made again became less rough because of a changed neighbour.
  bool others_are_as_they_were() {
    if (!base_.rough) return true;
    const std::size_t before = further_.size();
    std::size_t next = 0;
    for (const SiteId s : area_->wanted()) {
      const std::uint32_t count = fragments_made(s);
      const auto made = made_.fragments.begin() + static_cast<std::ptrdiff_t>(next);
      next += count;
      if (area_->changes(s)) continue;
      const std::vector<KeptFragment>& kept = base_.cells[s]->fragments;
      pacer_.step(64 * (1 + count));
      if (!std::equal(kept.begin(), kept.end(), made, made + count,
                      [](const KeptFragment& k, const Fragment& f) { return same_shape(k.fragment, f); }))
        further_.push_back(s);
    }
    return further_.size() == before;
  }

  bool keeps_to_limits() {
    double smallest = HUGE_VAL;
    static const std::vector<SiteId> kNone;
    for (const SiteId s : area_ ? area_->changed() : kNone)
      for (const KeptFragment& kept : out_.next.cells[s]->fragments)
        smallest = std::fmin(smallest, kept.fragment.mass.volume);
    const std::optional<SizeFigures> size =
        size_after(limits_, solid_.report.volume, base_.size, out_.next.figures, smallest);
    if (!size) return false;
    out_.next.size = *size;
    out_.next.size.united =
        out_.next.figures.pieces - static_cast<std::uint32_t>(out_.next.figures.volumes.size());
    return true;
  }

  /// Finds which fragments of a changed cell are new, changed or gone.
  void compare(SiteId s, const std::vector<KeptFragment>& before, const std::vector<KeptFragment>& after) {
    for (const std::uint32_t k : differing(before, after, out_.delta, execution_))
      out_.changed.push_back({s, k});
  }

  void replace_cells() {
    if (parameters_.hulls == Hulls::kConvex) {
      FragmentSet set;
      state_lattice(solid_, set);
      set.fragments.swap(made_.fragments);
      hulls_ = make_collision_hulls(set, std::move(hulls_), parameters_.hull_limits, execution_);
      trim_at_contacts(set, solid_, hulls_, execution_);
      set.fragments.swap(made_.fragments);
    }
    SharedBlocks<std::shared_ptr<const KeptCell>>::Edit cells(out_.next.cells);
    static const std::vector<KeptFragment> kNone;
    std::size_t next = 0;
    for (const SiteId s : area_->wanted()) {
      const std::uint32_t count = fragments_made(s);
      pacer_.step(64 * (1 + count));
      if (!area_->changes(s)) {  // unchanged
        next += count;
        continue;
      }
      KeptCell cell;
      for (; cell.fragments.size() < count; ++next)
        cell.fragments.push_back(
            {std::move(made_.fragments[next]),
             hulls_.of_fragment.empty() ? FragmentHulls() : std::move(hulls_.of_fragment[next]),
             made_.volumes_file[next]});
      for (const std::uint32_t t : triangles_by_cell_[part().local(s)])
        cell.triangles.push_back(surface_.triangles[t]);
      if (area_->is_owner(s)) {
        cell.pieces = made_.pieces[area_->number_of(s)];
        if (area_->members_of(s).size() > 1) cell.members = area_->members_of(s);
      }
      out_.next.cell_bytes += memory_size(cell);
      if (area_->is_new(s)) {
        compare(s, kNone, cell.fragments);
        cells.push_back(std::make_shared<const KeptCell>(std::move(cell)));
      } else {
        compare(s, base_.cells[s]->fragments, cell.fragments);
        out_.next.cell_bytes -= memory_size(*base_.cells[s]);
        cells.at(s) = std::make_shared<const KeptCell>(std::move(cell));
      }
    }
  }

  void replace_late_unions() {
    std::vector<Union> late = std::move(made_.late);
    const std::size_t made = late.size();
    for (const Union& pieces : base_.late->all) {
      pacer_.step(8);
      if (!area_->changes(pieces.front().lowest)) late.push_back(pieces);
    }
    if (made == 0 && late.size() == base_.late->all.size()) return;
    std::sort(late.begin(), late.end());
    out_.next.late = std::make_shared<const KeptUnions>(std::move(late), execution_);
  }

  /// Returns false if two fragments have the same id, which only the whole answer can resolve.
  bool sum_up_again() {
    std::optional<FragmentFigures> after = figures_after(
        base_.figures, area_->changed(), area_->first_new(),
        [&](SiteId s) -> const KeptCell& { return *base_.cells[s]; },
        [&](SiteId s) -> const KeptCell& { return *out_.next.cells[s]; }, execution_);
    if (!after) return false;
    out_.next.figures = std::move(*after);
    return true;
  }

  /// Uses the new bonds of changed cells and the old bonds of the others. A cell next to a changed one may
  /// have been made again, with only the number of fragments known for some of its neighbours.
  void replace_bonds() {
    const auto place = [&](std::uint32_t fragment) {
      const auto after = std::upper_bound(made_.first_of.begin(), made_.first_of.end(), fragment);
      const auto owner = static_cast<std::size_t>(after - made_.first_of.begin()) - 1;
      return PlaceInAnswer{area_->owners()[owner], fragment - made_.first_of[owner]};
    };
    SharedBlocks<std::shared_ptr<const std::vector<KeptBond>>>::Edit bonds(out_.next.bonds);
    for (std::size_t n = area_->first_new(); n < now().site_count(); ++n) bonds.push_back(nullptr);
    auto made = made_.bonds.begin();  // ascending by a, then b
    for (const SiteId s : area_->owners()) {
      const bool changes = area_->changes(s);
      std::vector<KeptBond> here;
      const std::vector<KeptBond>* before = base_.bonds.size() > s ? base_.bonds[s].get() : nullptr;
      bool same = true;
      if (before)
        for (const KeptBond& bond : *before) {
          const bool stays = !changes && !area_->changes(bond.other_cell);
          same &= stays;
          if (stays) here.push_back(bond);
        }
      for (; made != made_.bonds.end(); ++made) {
        const PlaceInAnswer a = place(made->a), b = place(made->b);
        if (a.site != s) break;
        pacer_.step(16);
        if (!changes && !area_->changes(b.site)) continue;
        here.push_back({a.fragment, b.site, b.fragment, made->area, made->centroid, made->normal});
        same = false;
      }
      if (same) continue;
      std::sort(here.begin(), here.end(), [](const KeptBond& x, const KeptBond& y) {
        return std::tie(x.fragment, x.other_cell, x.other_fragment) <
               std::tie(y.fragment, y.other_cell, y.other_fragment);
      });
      bonds.at(s) = here.empty() ? nullptr : std::make_shared<const std::vector<KeptBond>>(std::move(here));
    }
    if (made != made_.bonds.end()) throw InternalError("a bond of fragments outside of the part");
  }

  void replace_surface() {
    SharedBlocks<SiteId, 256>::Edit label(out_.next.label);
    for (std::size_t v = 0; v < label_.size(); ++v) {
      pacer_.step(2);
      const SiteId s = part().sites[label_[v]];
      const VertexId vertex = surface_.vertices[v];
      if (label[vertex] != s) label.at(vertex) = s;
    }
  }

  void replace_states(const std::vector<TetId>& made) {
    SharedBlocks<std::uint32_t, 256>::Edit state(out_.next.state);
    while (out_.next.state.size() < now().tet_end()) state.push_back(WindingStates::kNothing);
    IdTable number;  // per new tetrahedron: its index in `around`
    std::vector<std::vector<PartWinding>> around(made.size());
    for (std::uint32_t k = 0; k < made.size(); ++k) number.slot(made[k]) = k;
    for (const InnerVertex& v : inner_vertices_) {
      pacer_.step(2);
      if (const std::uint32_t k = number.find(part().tets[v.tet]); k != IdTable::kEmpty)
        around[k].push_back({surface_.parts[v.part], v.winding});
    }
    std::shared_ptr<WindingStates> more;  // with new states; most hits have none
    for (std::size_t k = 0; k < made.size(); ++k) {
      pacer_.step(4);
      std::uint32_t number_of_state = more ? kNoIndex : out_.next.states->find(around[k]);
      if (number_of_state == kNoIndex) {
        if (!more) more = std::make_shared<WindingStates>(*out_.next.states);
        number_of_state = more->number_of(around[k]);
      }
      state.at(made[k]) = number_of_state;
    }
    if (more) out_.next.states = std::move(more);
  }

  const Solid& solid_;
  const LocalBase& base_;
  const FractureParameters& parameters_;
  std::vector<SiteId>& further_;
  std::size_t& made_in_all_;
  const Execution& execution_;
  const SizeLimits limits_;
  Pacer pacer_;
  HitOutcome out_;
  std::optional<HitArea> area_;
  std::vector<TetId> known_;                 // tetrahedra of the part
  std::vector<InnerVertex> known_windings_;  // `tet` is an index into known_
  SolidPatch surface_;
  // The new data of the part.
  WantedFragments made_;
  CollisionHulls hulls_;
  std::vector<std::vector<std::uint32_t>> triangles_by_cell_;
  std::vector<SiteId> label_;
  std::vector<InnerVertex> inner_vertices_;
};

}  // namespace

std::optional<HitOutcome> hit_cells(const Solid& solid, const LocalBase& base, std::span<const Vec3d> points,
                                    std::span<const std::uint32_t> groups,
                                    const FractureParameters& parameters, const Execution& execution) {
  // Cuts make others less rough at distances of about a triangle's length; more than two steps are rare.
  constexpr int kMostTries = 4;
  std::vector<SiteId> further;
  std::size_t made = 0;
  for (int k = 0; k < kMostTries; ++k) {
    const std::size_t before = further.size();
    std::optional<HitOutcome> out =
        LocalHit(solid, base, parameters, further, made, execution).run(points, groups);
    if (out || further.size() == before) return out;
  }
  return std::nullopt;
}

}  // namespace fracture
