// Kept fragments, and the figures of all of them: how these change with a few cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

struct KeptFragment {
  Fragment fragment;
  FragmentHulls hulls;     ///< none where none were asked for
  double volume_file = 0;  ///< m³, as the certificate sums it
};

/// What is in one cell.
struct KeptCell {
  /// In the order of their islands. Those of cells that stay together are at the lowest of them, and what is united of
  /// several cells' pieces is where the first of these is.
  std::vector<KeptFragment> fragments;
  std::vector<std::uint32_t> triangles;  ///< of the solid, that meet the cell; ascending
  /// At the lowest of cells that stay together: all of these, ascending. Empty: the cell is for itself.
  std::vector<SiteId> members{};
  std::uint32_t pieces = 0;  ///< of it or its members, the united ones, too
};

/// Sums over all fragments of an answer, and what is summed in their order.
struct FragmentFigures {
  std::vector<std::uint32_t> first_of;  ///< per cell + 1: the range of its fragments
  // Per fragment, in the order of the answer.
  std::vector<double> volumes, volumes_file;  ///< m³
  std::vector<double> surface_areas;          ///< m²
  // Of all of them.
  std::vector<double> sorted_volumes;     ///< m³, body_volume() of each, ascending
  std::vector<std::uint64_t> sorted_ids;  ///< ascending
  std::uint64_t open_edges = 0, caps = 0, triangles = 0;
  std::uint32_t cells = 0;   ///< that have pieces; some stay together
  std::uint32_t pieces = 0;  ///< of them; more than fragments where some are united
  HullReport hulls{};

  /// To what is summed in order.
  void append(const KeptFragment& kept);
  /// In the sums over all; times: 1, or -1 to take it out.
  void count(const KeptFragment& kept, int times);
};
/// `pieces`: per site, as KeptCell has them.
FragmentFigures figures_of(const std::vector<KeptFragment>& fragments,
                           const std::vector<std::uint32_t>& pieces, const Execution& execution);

/// The figures after cells have changed (ascending; those from `first_new` on are new). `was` and `is`: such a cell.
/// Nothing where two fragments have the same id then. Throws Interrupted.
using CellOf = std::function<const KeptCell&(SiteId)>;
std::optional<FragmentFigures> figures_after(const FragmentFigures& before, std::span<const SiteId> changed,
                                             SiteId first_new, const CellOf& was, const CellOf& is,
                                             const Execution& execution);

/// What limits of size say where they unite nothing, as they did not before; nothing where they might. `volume`: of the
/// solid, `smallest`: of the fragments that were made anew, m³.
std::optional<SizeFigures> size_after(const SizeLimits& limits, double volume, const SizeFigures& before,
                                      const FragmentFigures& after, double smallest);

/// Bytes, those of the object itself too.
std::size_t memory_size(const KeptFragment& kept);

}  // namespace fracture
