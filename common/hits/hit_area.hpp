// Which cells a hit changes, which are made again with them, and the part of the whole that this takes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/delaunay/kept_tetrahedralization.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/unions.hpp"
#include "common/hits/kept_answer.hpp"

namespace fracture {

/// Cells that stay together are named by the lowest of them, their owner.
class HitArea {
 public:
  /// `next`: the answer after the hit, which has the new sites already and gets to know who stays together with whom.
  /// `groups`: of the points; empty: each for itself. `further`: cells that are to be made, too. `triangle_count`: of the
  /// solid. Throws Interrupted.
  HitArea(const LocalBase& base, LocalBase& next, const KeptTetrahedralization::Insertion& inserted,
          std::span<const std::uint32_t> groups, const std::vector<SiteId>& further,
          std::size_t triangle_count, const Execution& execution);

  /// New cells and those that are not what they were; with each cell those that stay together with it, or had pieces
  /// united with its own. Ascending.
  const std::vector<SiteId>& changed() const { return changed_; }
  bool changes(SiteId s) const { return std::binary_search(changed_.begin(), changed_.end(), s); }
  /// These, and cells beside them of which it is only known which of their pieces a cap leads to when all are there.
  const std::vector<SiteId>& wanted() const { return wanted_; }
  /// Of the solid, that met wanted cells. Ascending.
  const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  /// All tetrahedra at wanted cells, and at others that share their triangles.
  const KeptTetrahedralization::Part& part() const { return part_; }
  /// Of the cells of the part. Ascending.
  const std::vector<SiteId>& owners() const { return owners_; }
  std::uint32_t number_of(SiteId owner) const {
    return static_cast<std::uint32_t>(std::lower_bound(owners_.begin(), owners_.end(), owner) -
                                      owners_.begin());
  }

  bool is_new(SiteId s) const { return s >= first_new_; }
  SiteId first_new() const { return first_new_; }
  bool is_owner(SiteId s) const { return next_.lowest_of(s) == s; }
  /// Those that stay together with an owner, and itself; empty: it is alone.
  const std::vector<SiteId>& members_of(SiteId owner) const;
  /// How many fragments an owner had.
  std::uint32_t fragments_before(SiteId owner) const {
    const std::vector<std::uint32_t>& first_of = base_.figures.first_of;
    return is_new(owner) ? 0 : first_of[owner + 1] - first_of[owner];
  }

  /// Owners and cells of the part, numbered as in the whole. Of those that are not wanted only some cells may be here.
  Ownership ownership() const;
  /// Unions of the pieces of wanted cells that no hit is beside, this one or one before.
  std::vector<Union> active_unions(const Ownership& ownership) const;
  /// Unions of what is too small beside earlier hits, of wanted cells that do not change.
  std::vector<Union> lasting_late_unions() const;
  /// Is one of these beside a hit?
  bool takes_unions_apart() const;

 private:
  void join_new_cells(const std::vector<std::uint32_t>& points, std::span<const std::uint32_t> groups,
                      LocalBase& next);
  void complete(std::vector<SiteId>& sites);
  bool has_unions(SiteId owner) const;
  std::vector<std::uint32_t> of_wanted(const KeptUnions& unions) const;  ///< ascending
  void find_wanted(const std::vector<TetId>& made, const std::vector<SiteId>& further);
  void find_part(std::size_t triangle_count);

  const LocalBase& base_;
  const LocalBase& next_;
  const Execution& execution_;
  Pacer pacer_;
  SiteId first_new_;
  std::vector<SiteId> changed_, wanted_, owners_;
  std::vector<std::vector<SiteId>> members_of_new_;  // per new site; only where cells stay together
  std::vector<std::uint32_t> triangles_;
  KeptTetrahedralization::Part part_;
};

}  // namespace fracture
