// What the random inputs of these tests are made from.
#pragma once

#include <cstdint>

namespace fracture::test {

inline constexpr std::uint64_t kSeed = 20261121;

}  // namespace fracture::test
