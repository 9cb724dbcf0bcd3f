// Rough cuts in the stored data of an answer: the cuts, indexed by cell, and the calmings that made cuts less
// rough.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/shared_blocks.hpp"
#include "common/rough/roughen.hpp"

namespace fracture {

/// The cuts between a cell and cells with higher numbers.
struct CellCuts {
  Box box;                                                                  ///< contains all of them
  std::shared_ptr<const std::vector<std::shared_ptr<const KeptCut>>> cuts;  ///< null: none
};

struct LocalRough {
  RoughReport report;
  SharedBlocks<CellCuts> cuts;  ///< per site
  std::shared_ptr<const std::vector<Calming>> calmings;
  /// As in RoughTrace; after hits, upper bounds.
  std::uint64_t pairs = 0;
  double area = 0, edges = 0;
  std::size_t cut_bytes = 0;  ///< memory behind `cuts`; answers that share memory each count it
};
/// Bytes in addition to those of the object itself.
std::size_t heap_size(const LocalRough& rough);

/// Stores the cuts of a trace. All functions here throw Interrupted.
LocalRough keep_cuts(RoughTrace trace, const RoughReport& report, std::uint32_t sites,
                     const Execution& execution);

/// Implements RoughWhole::near.
std::vector<const KeptCut*> cuts_near(const LocalRough& rough, std::vector<Box> boxes,
                                      std::span<const SiteId> made, const SeamLattice& lattice,
                                      const Execution& execution);

/// Updates the cuts after the cells `made` were made again. `around`: these cells and all that share a cut
/// with them, now or before, ascending. Returns nothing if too many pairs of triangles might have been tested
/// in the whole.
std::optional<LocalRough> replace_cuts(const LocalRough& before, RoughPart part, std::span<const SiteId> made,
                                       std::span<const SiteId> around, std::uint32_t sites,
                                       const Execution& execution);

}  // namespace fracture
