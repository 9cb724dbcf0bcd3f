// Rough cuts in what is kept of an answer: each cut where hits find it, and what made cuts less rough.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/shared_blocks.hpp"
#include "common/rough/roughen.hpp"

namespace fracture {

/// The cuts between a cell and those of higher number.
struct CellCuts {
  Box box;                                                                  ///< around all of them
  std::shared_ptr<const std::vector<std::shared_ptr<const KeptCut>>> cuts;  ///< null: none
};

struct LocalRough {
  RoughReport report;
  SharedBlocks<CellCuts> cuts;  ///< per site
  std::shared_ptr<const std::vector<Calming>> calmings;
  /// As in RoughTrace; after hits no less than that.
  std::uint64_t pairs = 0;
  double area = 0, edges = 0;
  std::size_t cut_bytes = 0;  ///< of memory behind `cuts`; those that answers share are counted by each
};
/// Beyond those of the object itself.
std::size_t heap_size(const LocalRough& rough);

/// Throws Interrupted, as all here.
LocalRough keep_cuts(RoughTrace trace, const RoughReport& report, std::uint32_t sites,
                     const Execution& execution);

/// RoughWhole::near.
std::vector<const KeptCut*> cuts_near(const LocalRough& rough, std::vector<Box> boxes,
                                      std::span<const SiteId> made, const SeamLattice& lattice,
                                      const Execution& execution);

/// After the cells `made` were made anew; `around`: these and all that share a cut with them, now or before, ascending.
/// Nothing where in the whole too many pairs of triangles might have been met.
std::optional<LocalRough> replace_cuts(const LocalRough& before, RoughPart part, std::span<const SiteId> made,
                                       std::span<const SiteId> around, std::uint32_t sites,
                                       const Execution& execution);

}  // namespace fracture
