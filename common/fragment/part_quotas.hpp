// Number of fragments that each part of a solid, or each group of parts, may have, so that together they
// have the requested number.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Parts share the fragments in proportion to the cells in them. A cell that lies in several parts counts
/// in each part by its share of volume there. For uniform sites, this is proportional to the part's volume.
/// If the pattern makes small cells (near a hit), their part gets more fragments. Each part gets at least
/// one fragment, and at most as many as it has pieces. The method is D'Hondt's (1882): the next fragment
/// goes to the part that has the most cells per fragment; ties go to the lowest part. If there are at least
/// as many parts as requested fragments, each part gets one, and a quarter of the requested number is
/// distributed in addition.
class PartQuotas {
 public:
  /// `part_of`: the part, or group of parts, of a piece. `volumes`: per group of pieces, by its name; the pieces
  /// of a group share a cell and a group of parts. `left`: per part, the number of pieces that remain after the
  /// unions so far. Throws Interrupted.
  PartQuotas(const Pieces& pieces, const std::function<std::uint32_t(std::uint32_t)>& part_of,
             const std::vector<double>& volumes, std::vector<std::uint32_t> left, std::uint32_t wanted,
             const Execution& execution);

  /// Whether the part has more pieces than it may.
  bool over(std::uint32_t part) const { return left_[part] > quota_[part]; }
  /// Whether any part has more pieces than it may.
  bool any_over() const { return over_ > 0; }
  /// Notes that two pieces of the part were united.
  void unite(std::uint32_t part) { over_ -= left_[part]-- > quota_[part]; }
  std::uint32_t parts() const { return parts_; }  ///< number of parts that have pieces

 private:
  std::vector<std::uint32_t> quota_, left_;  // per part
  std::uint64_t over_ = 0;                   // number of pieces beyond the quotas, over all parts
  std::uint32_t parts_ = 0;
};

}  // namespace fracture
