// Number of triangles in all fragments after the first unions of a sequence.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Counts triangles. A union always makes a group of the same pieces, whichever number of unions is asked
/// about, so its faces are joined only once.
class UnionTriangles {
 public:
  /// All arguments are borrowed. `unions`: pairs of group names, as they are after the unions before.
  UnionTriangles(const RestrictedDiagram& diagram, const Pieces& pieces, const PieceGroups& groups,
                 const std::vector<std::pair<std::uint32_t, std::uint32_t>>& unions,
                 const Execution& execution)
      : d_(diagram),
        pieces_(pieces),
        before_(groups),
        unions_(unions),
        execution_(execution),
        of_union_(unions.size(), kUnknown),
        of_group_before_(pieces.pieces.size(), kUnknown) {}

  /// Returns the number of triangles in all groups after the first `count` unions. Throws Interrupted.
  std::uint64_t after(std::size_t count);

 private:
  static constexpr std::uint64_t kUnknown = ~std::uint64_t{0};

  const RestrictedDiagram& d_;
  const Pieces& pieces_;
  const PieceGroups& before_;
  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& unions_;
  const Execution& execution_;
  std::vector<std::uint64_t> of_union_, of_group_before_;  // triangles in that group, once counted
};

}  // namespace fracture
