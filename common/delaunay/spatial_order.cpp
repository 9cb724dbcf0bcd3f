#include "common/delaunay/spatial_order.hpp"

#include <algorithm>
#include <bit>

#include "common/base/hilbert_curve.hpp"
#include "common/base/pacer.hpp"
#include "common/base/radix_sort.hpp"
#include "common/base/random.hpp"

namespace fracture {
namespace {

constexpr int kBits = 19;        // per axis; the curve has 57 bits
constexpr int kCoarseBits = 33;  // sorted by radix; the others only if they matter
constexpr std::size_t kFirstRound = 64;

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const Vec3d> points, const Execution& execution) {
  Pacer pacer(execution);
  Box box;
  for (const Vec3d& p : points) box.add(p);
  const HilbertCurve curve(box, kBits);

  // Round 0 is the last one. The number of rounds grows with the logarithm of the number of points.
  int rounds = 1;
  for (std::size_t n = points.size(); n > kFirstRound; n /= 8) ++rounds;
  Random random(0x9d5c0f1e5ca1ab1eull);
  std::vector<std::vector<Keyed>> items(rounds);
  items[0].reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    pacer.step(2);
    const int round = std::countr_zero(random() | std::uint64_t{1} << 63) / 3;
    items[std::min(round, rounds - 1)].push_back({curve.at(points[i]), static_cast<std::uint32_t>(i)});
  }

  std::vector<std::uint32_t> order;
  order.reserve(points.size());
  for (int r = rounds; r-- > 0;) {
    std::vector<Keyed>& round = items[r];
    constexpr int kCoarse = 3 * kBits - kCoarseBits;
    radix_sort(round, kCoarse, 3 * kBits, pacer);
    for (std::size_t i = 0; i < round.size();) {
      std::size_t end = i + 1;
      while (end < round.size() && round[end].key >> kCoarse == round[i].key >> kCoarse) ++end;
      if (end - i > 1)
        sort_with_polls(execution, round.begin() + i, round.begin() + end,
                        [](const Keyed& a, const Keyed& b) {
                          return a.key != b.key ? a.key < b.key : a.index < b.index;
                        });
      pacer.step(end - i);
      i = end;
    }
    for (const Keyed& k : round) order.push_back(k.index);
  }
  return order;
}

}  // namespace fracture
