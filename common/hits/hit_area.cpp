#include "common/hits/hit_area.hpp"

#include <map>
#include <utility>

#include "common/base/id_table.hpp"
#include "common/base/ranked_set.hpp"

namespace fracture {
namespace {

void sort_once(std::vector<SiteId>& sites, const Execution& execution) {
  sort_with_polls(execution, sites.begin(), sites.end());
  sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
}

}  // namespace

HitArea::HitArea(const LocalBase& base, LocalBase& next, const KeptTetrahedralization::Insertion& inserted,
                 std::span<const std::uint32_t> groups, const std::vector<SiteId>& further,
                 std::size_t triangle_count, const Execution& execution)
    : base_(base),
      next_(next),
      execution_(execution),
      pacer_(execution),
      first_new_(base.tetrahedra.site_count()) {
  join_new_cells(inserted.points, groups, next);
  find_wanted(inserted.made, further);
  find_part(triangle_count);
}

const std::vector<SiteId>& HitArea::members_of(SiteId owner) const {
  static const std::vector<SiteId> kNone;
  if (!is_new(owner)) return base_.cells[owner]->members;
  return members_of_new_.empty() ? kNone : members_of_new_[owner - first_new_];
}

/// Groups new cells like their points.
void HitArea::join_new_cells(const std::vector<std::uint32_t>& points, std::span<const std::uint32_t> groups,
                             LocalBase& next) {
  if (groups.empty() && base_.lowest.size() == 0) return;
  if (base_.lowest.size() == 0) next.lowest = SharedBlocks<SiteId, 256>(all_ids<SiteId>(first_new_));
  SharedBlocks<SiteId, 256>::Edit lowest(next.lowest);
  members_of_new_.resize(points.size());
  std::map<std::uint32_t, SiteId> first;  // per group
  for (std::size_t k = 0; k < points.size(); ++k) {
    pacer_.step(8);
    const SiteId s{first_new_ + k};
    const SiteId owner = groups.empty() ? s : first.emplace(groups[points[k]], s).first->second;
    lowest.push_back(owner);
    members_of_new_[owner - first_new_].push_back(s);
  }
}

/// Adds to each cell the cells that stay together with it or whose pieces are united with its own,
/// transitively.
void HitArea::complete(std::vector<SiteId>& sites) {
  for (SiteId& s : sites) s = next_.lowest_of(s);
  sort_once(sites, execution_);
  if (!base_.unions->all.empty() || !base_.late->all.empty()) {
    IdTable there, done, late_done;
    for (const SiteId s : sites) there.slot(s) = 1;
    const auto follow = [&](const KeptUnions& unions, IdTable& followed, SiteId s) {
      unions.each_of(s, [&](std::uint32_t number) {
        pacer_.step();
        if (std::exchange(followed.slot(number), 1) == 1) return;
        for (const PieceName& piece : unions.all[number]) {
          pacer_.step(4);
          std::uint32_t& slot = there.slot(piece.lowest);
          if (slot == IdTable::kEmpty) sites.push_back(piece.lowest);
          slot = 1;
        }
      });
    };
    for (std::size_t k = 0; k < sites.size(); ++k) {
      follow(*base_.unions, done, sites[k]);
      follow(*base_.late, late_done, sites[k]);
    }
  }
  for (std::size_t k = sites.size(); k-- > 0;) {
    const std::vector<SiteId>& members = members_of(sites[k]);
    if (members.size() > 1) sites.insert(sites.end(), members.begin() + 1, members.end());
  }
  sort_once(sites, execution_);
}

bool HitArea::has_unions(SiteId owner) const {
  bool has = false;
  for (const KeptUnions* unions : {base_.unions.get(), base_.late.get()})
    unions->each_of(owner, [&](std::uint32_t) { has = true; });
  return has;
}

void HitArea::find_wanted(const std::vector<TetId>& made, const std::vector<SiteId>& further) {
  for (const TetId t : made)
    for (const TetVertexId v : next_.tetrahedra.tet(t).v)
      if (v >= 4) changed_.push_back(SiteId{v - 4});
  changed_.insert(changed_.end(), further.begin(), further.end());
  complete(changed_);
  wanted_ = changed_;
  const FragmentFigures& before = base_.figures;
  if (before.cells == before.pieces && base_.unions->all.empty() && base_.late->all.empty())
    return;  // each cell has a single piece and is alone
  KeptTetrahedralization::PartMaker beside(next_.tetrahedra, execution_);
  for (const SiteId s : changed_)
    beside.add(s, [&](SiteId n) {
      const SiteId owner = next_.lowest_of(n);
      if (fragments_before(owner) > 1 || has_unions(owner)) wanted_.push_back(n);
    });
  complete(wanted_);
}

/// A triangle is convex, so the cells that it meets are connected.
void HitArea::find_part(std::size_t triangle_count) {
  RankedSet is_here(triangle_count);
  for (const SiteId s : wanted_) {
    if (is_new(s)) continue;
    for (const std::uint32_t t : base_.cells[s]->triangles) is_here.add(t);
    pacer_.step(base_.cells[s]->triangles.size());
  }
  is_here.close();
  triangles_.reserve(is_here.size());
  is_here.each([&](std::uint32_t t) { triangles_.push_back(t); });

  KeptTetrahedralization::PartMaker maker(next_.tetrahedra, execution_);
  std::vector<SiteId> around = wanted_;
  for (std::size_t k = 0; k < around.size(); ++k)
    maker.add(around[k], [&](SiteId n) {
      if (std::binary_search(wanted_.begin(), wanted_.end(), n)) return;
      const auto& of_cell = base_.cells[n]->triangles;
      pacer_.step(of_cell.size());
      if (std::any_of(of_cell.begin(), of_cell.end(), [&](std::uint32_t t) { return is_here.contains(t); }))
        around.push_back(n);
    });
  part_ = maker.finish();
  for (const SiteId s : part_.sites) owners_.push_back(next_.lowest_of(s));
  sort_once(owners_, execution_);
}

Ownership HitArea::ownership() const {
  Ownership o;
  o.sites_of_owner.resize(owners_.size());
  Pacer pacer(execution_);
  for (const SiteId s : ids<SiteId>(part_.sites.size())) {
    pacer.step(8);
    const std::uint32_t owner = number_of(next_.lowest_of(part_.sites[s]));
    o.owner_of_site.push_back(owner);
    o.sites_of_owner[owner].push_back(s);
    o.grouped = o.grouped || o.sites_of_owner[owner].size() > 1;
  }
  for (const SiteId s : owners_) {
    pacer.step(4);
    o.wanted.push_back(std::binary_search(wanted_.begin(), wanted_.end(), s));
  }
  return o;
}

std::vector<std::uint32_t> HitArea::of_wanted(const KeptUnions& unions) const {
  std::vector<std::uint32_t> numbers;
  for (const SiteId s : wanted_) unions.each_of(s, [&](std::uint32_t number) { numbers.push_back(number); });
  sort_with_polls(execution_, numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

std::vector<Union> HitArea::active_unions(const Ownership& ownership) const {
  std::vector<Union> unions;
  for (const std::uint32_t number : of_wanted(*base_.unions)) unions.push_back(base_.unions->all[number]);
  if (unions.empty()) return {};
  const auto is_of_hit = [&](SiteId s) { return part_.sites[s] >= base_.pattern_sites; };
  return fracture::active_unions(
      unions, owners_, touched_owners(part_.tetrahedra, base_.map, ownership, is_of_hit, execution_),
      execution_);
}

std::vector<Union> HitArea::lasting_late_unions() const {
  std::vector<Union> unions;
  for (const std::uint32_t number : of_wanted(*base_.late)) {
    const Union& pieces = base_.late->all[number];
    // If one of its cells changes, all of them do.
    if (!changes(pieces.front().lowest)) unions.push_back(pieces);
  }
  return unions;
}

bool HitArea::takes_unions_apart() const {
  const std::size_t all = of_wanted(*base_.unions).size();
  return all > 0 && active_unions(ownership()).size() < all;
}

}  // namespace fracture
