// The clock of the benchmarks.
#pragma once

#include <chrono>

namespace fracture::bench {

/// Milliseconds since an arbitrary moment; never goes back.
inline double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace fracture::bench
