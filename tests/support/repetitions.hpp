// How often a test repeats what it draws at random.
#pragma once

namespace fracture::test {

/// So many repetitions; under a sanitizer a tenth, at least 20. There each takes ten times as long. The values are judged by the
/// release build, and a sanitizer looks at how they are computed.
constexpr int repetitions(int count) {
#ifdef FRACTURE_SANITIZED
  return count < 200 ? (count < 20 ? count : 20) : count / 10;
#else
  return count;
#endif
}

}  // namespace fracture::test
