// The seed of the random inputs of these tests.
#pragma once

#include <cstdint>

namespace fracture::test {

inline constexpr std::uint64_t kSeed = 20261121;

}  // namespace fracture::test
