// The sizes of tests: usual ones, long ones for scripts/test --full, and short ones for sanitizers.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace fracture::test {

/// Are the long tests wanted?
inline bool full_tests() { return std::getenv("FRACTURE_TEST_FULL") != nullptr; }

/// Are short tests enough? Yes under a sanitizer, unless FRACTURE_TEST_USUAL or FRACTURE_TEST_FULL is set. A sanitizer finds memory
/// errors in small cases, and is five to ten times as slow. The release build judges the geometry at the usual sizes.
inline bool short_tests() {
#ifdef FRACTURE_SANITIZED
  return !full_tests() && !std::getenv("FRACTURE_TEST_USUAL");
#else
  return false;
#endif
}

/// The first in short tests, else the second.
template <class T>
T sized(T few, T usual) {
  return short_tests() ? few : usual;
}

/// For tests that run each of several cases on each of several inputs, by their numbers from 0 on: does this case run on this
/// input? In short tests each case runs on one input in `rounds`, and each input has one case in `rounds`.
inline bool has_turn(std::size_t input, std::size_t test_case, std::size_t rounds) {
  return !short_tests() || (input + test_case) % rounds == 0;
}

}  // namespace fracture::test
