#include "common/base/hilbert_curve.hpp"

#include <cmath>

namespace fracture {
namespace {

// Hamilton's state machine. A state is (entry corner e, direction d) of the curve through a subcube: 8 x 3
// states. Octants are numbered x + 2y + 4z.
struct HilbertTable {
  std::uint8_t digit[24][8];
  std::uint8_t next[24][8];
};

constexpr std::uint32_t rotate_left3(std::uint32_t v, std::uint32_t by) {
  by %= 3;
  return (v << by | v >> (3 - by)) & 7;
}
constexpr std::uint32_t gray(std::uint32_t w) { return w ^ w >> 1; }
constexpr std::uint32_t trailing_ones(std::uint32_t w) {
  std::uint32_t n = 0;
  for (; w & 1; w >>= 1) ++n;
  return n;
}

constexpr HilbertTable make_hilbert_table() {
  HilbertTable table{};
  for (std::uint32_t e = 0; e < 8; ++e)
    for (std::uint32_t d = 0; d < 3; ++d)
      for (std::uint32_t w = 0; w < 8; ++w) {
        const std::uint32_t octant = rotate_left3(gray(w), d + 1) ^ e;
        const std::uint32_t entry = w == 0 ? 0 : gray((w - 1) / 2 * 2);
        const std::uint32_t direction =
            w == 0 ? 0 : (w % 2 == 0 ? trailing_ones(w - 1) : trailing_ones(w)) % 3;
        const std::uint32_t next_e = e ^ rotate_left3(entry, d + 1);
        const std::uint32_t next_d = (d + direction + 1) % 3;
        table.digit[e * 3 + d][octant] = static_cast<std::uint8_t>(w);
        table.next[e * 3 + d][octant] = static_cast<std::uint8_t>(next_e * 3 + next_d);
      }
  return table;
}
constexpr HilbertTable kHilbert = make_hilbert_table();

}  // namespace

std::uint64_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits) {
  std::uint64_t index = 0;
  std::uint32_t state = 0;
  for (int b = bits - 1; b >= 0; --b) {
    const std::uint32_t octant = (x >> b & 1) | (y >> b & 1) << 1 | (z >> b & 1) << 2;
    index = index << 3 | kHilbert.digit[state][octant];
    state = kHilbert.next[state][octant];
  }
  return index;
}

HilbertCurve::HilbertCurve(const Box& box, int bits)
    : corner_(box.min), side_(box.longest_side()), last_cell_((1 << bits) - 1), bits_(bits) {}

std::uint64_t HilbertCurve::at(const Vec3d& point) const {
  const auto cell = [&](double v, double low) {
    const double c = (v - low) / side_ * last_cell_;  // NaN if the box has no size
    return static_cast<std::uint32_t>(c > 0 ? std::fmin(c, last_cell_) : 0);
  };
  return hilbert_index(cell(point.x, corner_.x), cell(point.y, corner_.y), cell(point.z, corner_.z), bits_);
}

}  // namespace fracture
