// How many fragments each part of a solid, or each group of parts, may have, so that all have as many as were asked for.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Parts share the fragments in proportion to the cells in them, where a cell that lies in several counts in
/// each by its volume there: for uniform sites that is the volume of the part, and where the pattern makes small
/// cells (near a hit) it makes many. Each gets at least one, and no more than it has pieces, by the method of
/// D'Hondt (1882): the next fragment goes to the part that has the most cells for each of its own, ties to the
/// lowest part. Where there are as many parts as that, a quarter of what was asked is divided beyond one for
/// each.
class PartQuotas {
 public:
  /// `part_of`: the part, or group of parts, of a piece. `volumes`: of the pieces. `left`: per part, the number of pieces
  /// after those united so far. Throws Interrupted.
  PartQuotas(const Pieces& pieces, const std::function<std::uint32_t(std::uint32_t)>& part_of,
             const std::vector<double>& volumes, std::vector<std::uint32_t> left, std::uint32_t wanted,
             const Execution& execution);

  /// Does the part have more pieces than it may?
  bool over(std::uint32_t part) const { return left_[part] > quota_[part]; }
  /// Does any?
  bool any_over() const { return over_ > 0; }
  /// Two of its pieces are one now.
  void unite(std::uint32_t part) { over_ -= left_[part]-- > quota_[part]; }
  std::uint32_t parts() const { return parts_; }  ///< that have pieces

 private:
  std::vector<std::uint32_t> quota_, left_;  // per part
  std::uint64_t over_ = 0;                   // pieces that are too many, of all parts
  std::uint32_t parts_ = 0;
};

}  // namespace fracture
