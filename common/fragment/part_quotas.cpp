#include "common/fragment/part_quotas.hpp"

#include <algorithm>
#include <queue>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Returns, per part, the sum of its shares of all cells.
std::vector<double> cells_in_parts(const Pieces& pieces,
                                   const std::function<std::uint32_t(std::uint32_t)>& part_of,
                                   const std::vector<double>& volumes, std::uint32_t parts, Pacer& pacer) {
  std::vector<double> cells(parts, 0);
  const std::vector<Piece>& all = pieces.pieces;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {  // pieces are sorted by owner
    double whole = 0;
    for (end = begin; end < all.size() && all[end].owners[0] == all[begin].owners[0]; ++end)
      whole += std::max(volumes[end], 0.0);
    pacer.step(end - begin);
    for (std::size_t k = begin; k < end && whole > 0; ++k)
      cells[part_of(static_cast<std::uint32_t>(k))] += std::max(volumes[k], 0.0) / whole;
  }
  return cells;
}

}  // namespace

PartQuotas::PartQuotas(const Pieces& pieces, const std::function<std::uint32_t(std::uint32_t)>& part_of,
                       const std::vector<double>& volumes, std::vector<std::uint32_t> left,
                       std::uint32_t wanted, const Execution& execution)
    : quota_(left.size(), 1), left_(std::move(left)) {
  Pacer pacer(execution);
  const auto count = static_cast<std::uint32_t>(left_.size());
  for (const std::uint32_t n : left_) parts_ += n > 0;

  const std::vector<double> cells = cells_in_parts(pieces, part_of, volumes, count, pacer);
  struct Claim {
    double cells_for_each;  // cells per fragment, if the part had one more
    std::uint32_t part;
    bool operator<(const Claim& other) const {
      return cells_for_each != other.cells_for_each ? cells_for_each < other.cells_for_each
                                                    : part > other.part;
    }
  };
  std::priority_queue<Claim> claims;
  const auto claim = [&](std::uint32_t part) {
    pacer.step(16);
    if (left_[part] > quota_[part]) claims.push({cells[part] / (quota_[part] + 1), part});
  };
  for (std::uint32_t p = 0; p < count; ++p) claim(p);
  std::uint32_t more = wanted >= parts_ ? wanted - parts_ : wanted / 4;
  for (; more > 0 && !claims.empty(); --more) {
    const std::uint32_t part = claims.top().part;
    claims.pop();
    ++quota_[part];
    claim(part);
  }
  for (std::uint32_t p = 0; p < count; ++p) over_ += left_[p] - std::min(left_[p], quota_[p]);
}

}  // namespace fracture
