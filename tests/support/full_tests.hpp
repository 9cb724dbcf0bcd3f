// Sizes of tests: usual ones, long ones for scripts/test --full, and short ones for sanitizers.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace fracture::test {

/// Whether long tests are requested.
inline bool full_tests() { return std::getenv("FRACTURE_TEST_FULL") != nullptr; }

/// Whether short tests are enough. They are under a sanitizer, unless FRACTURE_TEST_USUAL or
/// FRACTURE_TEST_FULL is set. A sanitizer finds memory errors in small cases, and is five to ten times as
/// slow. The release build judges the geometry at the usual sizes.
inline bool short_tests() {
#ifdef FRACTURE_SANITIZED
  return !full_tests() && !std::getenv("FRACTURE_TEST_USUAL");
#else
  return false;
#endif
}

/// Returns `few` in short tests and `usual` otherwise.
template <class T>
T sized(T few, T usual) {
  return short_tests() ? few : usual;
}

/// Whether a test runs this case on this input, both numbered from 0. In short tests each case runs on one
/// input in `rounds`, and each input has one case in `rounds`. Other tests run every case on every input.
inline bool has_turn(std::size_t input, std::size_t test_case, std::size_t rounds) {
  return !short_tests() || (input + test_case) % rounds == 0;
}

}  // namespace fracture::test
