// How often a test repeats its random draws.
#pragma once

namespace fracture::test {

/// Returns `count`. Under a sanitizer it returns a tenth, but at least 20 (or `count` if that is smaller),
/// because each repetition takes ten times as long there. The release build judges the values, and a
/// sanitizer checks how they are computed.
constexpr int repetitions(int count) {
#ifdef FRACTURE_SANITIZED
  return count < 200 ? (count < 20 ? count : 20) : count / 10;
#else
  return count;
#endif
}

}  // namespace fracture::test
