// Bonds that are equal to the last bit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/fragment/fragments.hpp"

namespace fracture::test {

inline bool same_bits(const Bond& a, const Bond& b) {
  static_assert(sizeof(Bond) == 2 * sizeof(std::uint32_t) + 8 * sizeof(double), "no padding");
  return std::memcmp(&a, &b, sizeof(Bond)) == 0;
}
inline bool same_bits(const std::vector<Bond>& a, const std::vector<Bond>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Bond& x, const Bond& y) { return same_bits(x, y); });
}

}  // namespace fracture::test
