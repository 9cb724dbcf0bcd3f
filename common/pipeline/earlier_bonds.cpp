#include "common/pipeline/earlier_bonds.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

using Corner = std::array<std::uint32_t, 3>;  // the bits of a position in the frame of the source

struct Triangle {
  std::array<Corner, 3> key;  ///< the same for its mirror image
  bool turned;                ///< its orientation: mirror images differ in it
  std::uint32_t cuts;         ///< index of the EarlierCuts that has it
  std::uint32_t first;        ///< index of its first corner
};

/// The triangles that two pieces share.
struct Share {
  std::uint32_t a, b;                ///< numbers after the hit, a < b
  std::uint32_t before_a, before_b;  ///< numbers before the hit, in the same order as a and b
  double area = 0;                   ///< m²
  Vec3d moment{}, normal{};          ///< the normal points from a to b
};

class Matcher {
 public:
  Matcher(std::span<const EarlierCuts> cuts, const Execution& execution)
      : cuts_(cuts), execution_(execution), pacer_(execution) {}

  /// Returns the shares, ascending by the numbers before the hit, lower first, and then after it.
  std::vector<Share> run() {
    for (std::uint32_t c = 0; c < cuts_.size(); ++c)
      for (const IndexRange& range : cuts_[c].caps)
        for (std::uint32_t k = range.first; k < range.first + range.count; k += 3) add_triangle(c, k);
    sort_with_polls(
        execution_, triangles_.begin(), triangles_.end(), [](const Triangle& x, const Triangle& y) {
          return std::tie(x.key, x.turned, x.cuts, x.first) < std::tie(y.key, y.turned, y.cuts, y.first);
        });
    for (std::size_t first = 0, last = 0; first < triangles_.size(); first = last) {
      std::size_t turned = 0;
      for (; last < triangles_.size() && triangles_[last].key == triangles_[first].key; ++last)
        turned += triangles_[last].turned;
      const std::size_t straight = last - first - turned;
      pacer_.step(last - first);
      for (std::size_t k = 0; k < std::min(straight, turned); ++k)
        add_share(triangles_[first + k], triangles_[first + straight + k]);
    }
    return sum_shares();
  }

 private:
  Vec3d place(std::uint32_t c, std::uint32_t k) const {
    const KeptFragment& kept = *cuts_[c].fragment;
    return to_double(kept.world()[kept.fragment.indices[k]]);
  }

  void add_triangle(std::uint32_t c, std::uint32_t k) {
    pacer_.step(4);
    Triangle t{{}, false, c, k};
    for (std::uint32_t n = 0; n < 3; ++n) {
      const Vec3d p = place(c, k + n);
      for (std::size_t axis = 0; axis < 3; ++axis)
        t.key[n][axis] = std::bit_cast<std::uint32_t>(static_cast<float>(p[static_cast<int>(axis)]) + 0.0f);
    }
    std::rotate(t.key.begin(), std::min_element(t.key.begin(), t.key.end()), t.key.end());
    t.turned = t.key[2] < t.key[1];
    if (t.turned) std::swap(t.key[1], t.key[2]);
    triangles_.push_back(t);
  }

  void add_share(const Triangle& straight, const Triangle& turned) {
    const Triangle &x = cuts_[straight.cuts].number < cuts_[turned.cuts].number ? straight : turned,
                   &y = &x == &straight ? turned : straight;
    const EarlierCuts &a = cuts_[x.cuts], &b = cuts_[y.cuts];
    if (a.before == b.before) return;
    const Vec3d p = place(x.cuts, x.first), q = place(x.cuts, x.first + 1), r = place(x.cuts, x.first + 2);
    const Vec3d normal = 0.5 * cross(q - p, r - p);
    const double area = length(normal);
    shares_.push_back({a.number, b.number, a.before, b.before, area, (area / 3) * (p + q + r), normal});
  }

  std::vector<Share> sum_shares() {
    const auto key = [](const Share& s) {
      return std::tuple(std::min(s.before_a, s.before_b), std::max(s.before_a, s.before_b), s.a, s.b);
    };
    std::vector<std::uint32_t> order(shares_.size());
    for (std::uint32_t k = 0; k < order.size(); ++k) order[k] = k;
    sort_with_polls(execution_, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
      return std::pair(key(shares_[x]), x) < std::pair(key(shares_[y]), y);
    });
    std::vector<Share> sums;
    for (const std::uint32_t k : order) {
      pacer_.step();
      const Share& share = shares_[k];
      if (sums.empty() || key(sums.back()) != key(share)) {
        sums.push_back(share);
        continue;
      }
      Share& sum = sums.back();
      sum.area += share.area;
      sum.moment = sum.moment + share.moment;
      sum.normal = sum.normal + share.normal;
    }
    return sums;
  }

  const std::span<const EarlierCuts> cuts_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<Triangle> triangles_;
  std::vector<Share> shares_;
};

}  // namespace

std::vector<Bond> divided_bonds(std::span<const Bond> bonds, std::span<const EarlierCuts> cuts,
                                const Execution& execution) {
  const std::vector<Share> shares = Matcher(cuts, execution).run();
  Pacer pacer(execution);
  std::vector<Bond> divided;
  for (const Bond& bond : bonds) {
    pacer.step(4);
    const auto [lo, hi] = std::minmax(bond.a, bond.b);
    const auto pair = [](const Share& s) { return std::minmax(s.before_a, s.before_b); };
    const auto first =
        std::partition_point(shares.begin(), shares.end(), [&, lo = lo, hi = hi](const Share& s) {
          return pair(s) < std::pair<const std::uint32_t&, const std::uint32_t&>(lo, hi);
        });
    auto last = first;
    double all = 0;
    for (; last != shares.end() && pair(*last).first == lo && pair(*last).second == hi; ++last)
      all += last->area;
    for (auto share = first; share != last; ++share) {
      Bond part = bond;
      part.a = share->a;
      part.b = share->b;
      const bool same_direction = share->before_a == bond.a;
      if (last - first == 1) {
        if (!same_direction) part.normal = -1.0 * bond.normal;
      } else {
        if (!(share->area > 0)) continue;
        part.area = bond.area * (share->area / all);
        part.centroid = (1 / share->area) * share->moment;
        if (const double l = length(share->normal); l > 0)
          part.normal = (1 / l) * share->normal;
        else if (!same_direction)
          part.normal = -1.0 * bond.normal;
      }
      divided.push_back(part);
    }
  }
  return divided;
}

}  // namespace fracture
