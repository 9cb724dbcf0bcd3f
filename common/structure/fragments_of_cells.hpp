// The fragments in each cell of parts in contact.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Cells are numbered by part, then by site. Only cells that contain a fragment of the part are numbered.
class FragmentsOfCells {
 public:
  struct Cells {
    std::uint32_t begin, end;
    std::uint32_t size() const { return end - begin; }
  };

  /// Covers only parts that have a contact with an area. Linear, apart from sorting if the fragments are
  /// not in the order of their sites. Throws Interrupted.
  FragmentsOfCells(const Solid& solid, std::span<const Fragment* const> fragments,
                   const Execution& execution);

  Cells of(std::uint32_t part) const { return {part_begin_[part], part_begin_[part + 1]}; }
  SiteId site(std::uint32_t cell) const { return sites_[cell]; }
  /// Returns the cell of this part and site, or kNoIndex.
  std::uint32_t find(std::uint32_t part, SiteId site) const {
    const auto begin = sites_.begin() + part_begin_[part], end = sites_.begin() + part_begin_[part + 1];
    const auto at = std::lower_bound(begin, end, site);
    return at != end && *at == site ? static_cast<std::uint32_t>(at - sites_.begin()) : kNoIndex;
  }
  /// Indices of the cell's fragments, ascending; several if the cell divides the part into islands.
  std::span<const std::uint32_t> fragments(std::uint32_t cell) const {
    return {fragments_.data() + fragment_begin_[cell], fragment_begin_[cell + 1] - fragment_begin_[cell]};
  }
  /// Returns the part's fragment if it has only one; otherwise kNoIndex.
  std::uint32_t only(std::uint32_t part) const { return only_[part]; }

 private:
  std::vector<std::uint32_t> part_begin_;      // per part, plus the end
  std::vector<SiteId> sites_;                  // per cell
  std::vector<std::uint32_t> fragment_begin_;  // per cell, plus the end
  std::vector<std::uint32_t> fragments_;
  std::vector<std::uint32_t> only_;  // per part
};

}  // namespace fracture
