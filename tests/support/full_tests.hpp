// scripts/test --full.
#pragma once

#include <cstdlib>

namespace fracture::test {

/// Are the long tests wanted?
inline bool full_tests() { return std::getenv("FRACTURE_TEST_FULL") != nullptr; }

}  // namespace fracture::test
