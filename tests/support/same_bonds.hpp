// Bonds that are equal to the last bit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "common/fragment/fragments.hpp"

namespace fracture::test {

/// Compares all fields, but not the padding behind the last one.
inline bool same_bits(const Bond& a, const Bond& b) {
  return std::memcmp(&a, &b, offsetof(Bond, across_parts)) == 0 && a.across_parts == b.across_parts;
}
inline bool same_bits(const std::vector<Bond>& a, const std::vector<Bond>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Bond& x, const Bond& y) { return same_bits(x, y); });
}

}  // namespace fracture::test
