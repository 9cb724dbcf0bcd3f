// Stored fragments, and the statistics of all fragments, which can be updated for a few changed cells.
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
  FragmentHulls hulls;     ///< empty if none were requested
  double volume_file = 0;  ///< m³, as summed in the certificate
};

/// The contents of one cell.
struct KeptCell {
  /// Sorted by island. The fragments of cells that stay together are stored at the lowest of these cells. A
  /// union of pieces from several cells is stored at the cell of its first piece.
  std::vector<KeptFragment> fragments;
  std::vector<std::uint32_t> triangles;  ///< triangles of the solid that meet the cell; ascending
  /// At the lowest of cells that stay together: all of these cells, ascending. Empty: the cell is alone.
  std::vector<SiteId> members{};
  std::uint32_t pieces = 0;  ///< number in the cell or its members, including united ones
};

/// Statistics of all fragments of an answer, and values that are summed in their order.
struct FragmentFigures {
  std::vector<std::uint32_t> first_of;  ///< per cell + 1: its range of fragments
  // Per fragment, in the order of the answer.
  std::vector<double> volumes, volumes_file;  ///< m³
  std::vector<double> surface_areas;          ///< m²
  // Totals of all fragments.
  std::vector<double> sorted_volumes;     ///< m³, body_volume() of each fragment, ascending
  std::vector<std::uint64_t> sorted_ids;  ///< ascending
  std::vector<double> sorted_excesses;    ///< FragmentHulls::excess, ascending
  std::uint64_t open_edges = 0, caps = 0, triangles = 0;
  std::uint32_t cells = 0;   ///< cells that have pieces; some stay together
  std::uint32_t pieces = 0;  ///< pieces in these cells; more than fragments if some are united
  HullReport hulls{};

  /// Appends a fragment to the values that are summed in order.
  void append(const KeptFragment& kept);
  /// Adds a fragment to the totals; times: 1, or -1 to subtract it.
  void count(const KeptFragment& kept, int times);
};
/// `pieces`: per site, as in KeptCell.
FragmentFigures figures_of(const std::vector<KeptFragment>& fragments,
                           const std::vector<std::uint32_t>& pieces, const Execution& execution);

/// Returns the statistics after some cells have changed (ascending; those from `first_new` on are new). `was`
/// and `is` return such a cell before and after. Returns nothing if two fragments then have the same id.
/// Throws Interrupted.
using CellOf = std::function<const KeptCell&(SiteId)>;
std::optional<FragmentFigures> figures_after(const FragmentFigures& before, std::span<const SiteId> changed,
                                             SiteId first_new, const CellOf& was, const CellOf& is,
                                             const Execution& execution);

/// Returns the report of the size limits if they unite nothing, as before; returns nothing if they might.
/// `volume`: of the solid, `smallest`: of the fragments that were made again, m³.
std::optional<SizeFigures> size_after(const SizeLimits& limits, double volume, const SizeFigures& before,
                                      const FragmentFigures& after, double smallest);

/// Bytes, including the object itself.
std::size_t memory_size(const KeptFragment& kept);

}  // namespace fracture
