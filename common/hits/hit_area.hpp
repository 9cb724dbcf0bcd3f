// Determines which cells a hit changes, which are made again with them, and which part of the whole this
// requires.
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

/// A group of cells that stay together is identified by its lowest cell, its owner.
class HitArea {
 public:
  /// `next`: the answer after the hit. It already has the new sites; the constructor adds which of them stay
  /// together. `groups`: per point; empty: each point is alone. `further`: more cells to make again.
  /// `triangle_count`: of the solid. Throws Interrupted.
  HitArea(const LocalBase& base, LocalBase& next, const KeptTetrahedralization::Insertion& inserted,
          std::span<const std::uint32_t> groups, const std::vector<SiteId>& further,
          std::size_t triangle_count, const Execution& execution);

  /// New cells and changed cells, with all cells that stay together with them or had pieces united with
  /// theirs. Ascending.
  const std::vector<SiteId>& changed() const { return changed_; }
  bool changes(SiteId s) const { return std::binary_search(changed_.begin(), changed_.end(), s); }
  /// These cells, and neighbouring cells with several pieces. For the latter, only the whole cell shows which
  /// piece a cap leads to.
  const std::vector<SiteId>& wanted() const { return wanted_; }
  /// Triangles of the solid that met wanted cells. Ascending.
  const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  /// All tetrahedra at wanted cells, and at other cells that share their triangles.
  const KeptTetrahedralization::Part& part() const { return part_; }
  /// Owners of the cells of the part. Ascending.
  const std::vector<SiteId>& owners() const { return owners_; }
  std::uint32_t number_of(SiteId owner) const {
    return static_cast<std::uint32_t>(std::lower_bound(owners_.begin(), owners_.end(), owner) -
                                      owners_.begin());
  }

  bool is_new(SiteId s) const { return s >= first_new_; }
  SiteId first_new() const { return first_new_; }
  bool is_owner(SiteId s) const { return next_.lowest_of(s) == s; }
  /// The cells that stay together with an owner, including itself; empty: it is alone.
  const std::vector<SiteId>& members_of(SiteId owner) const;
  /// Number of fragments that an owner had.
  std::uint32_t fragments_before(SiteId owner) const {
    const std::vector<std::uint32_t>& first_of = base_.figures.first_of;
    return is_new(owner) ? 0 : first_of[owner + 1] - first_of[owner];
  }

  /// Owners and cells of the part, numbered as in the whole. For owners that are not wanted, only some cells
  /// may be included.
  Ownership ownership() const;
  /// Unions of the pieces of wanted cells that are not near any hit, neither this one nor an earlier one.
  std::vector<Union> active_unions(const Ownership& ownership) const;
  /// Unions of too small pieces near earlier hits, of wanted cells that do not change.
  std::vector<Union> lasting_late_unions() const;
  /// Whether one of the pattern's unions is near a hit.
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
  std::vector<std::vector<SiteId>> members_of_new_;  // per new site; only if cells stay together
  std::vector<std::uint32_t> triangles_;
  KeptTetrahedralization::Part part_;
};

}  // namespace fracture
