// Measures how far the peak of this process's resident memory grew.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <string>

namespace fracture::test {

class PeakMemory {
 public:
  PeakMemory() {
    std::ofstream("/proc/self/clear_refs") << 5;  // resets the peak (proc(5))
    before_ = status("VmRSS:");
  }

  /// A sanitizer keeps freed memory, and shadows of all memory. So under it this check always passes.
  testing::AssertionResult grew_by_less_than(std::int64_t bytes) const {
#ifdef FRACTURE_SANITIZED
    return testing::AssertionSuccess() << bytes << " bytes are not measured under a sanitizer";
#else
    const std::int64_t more = status("VmHWM:") - before_;
    if (more < bytes) return testing::AssertionSuccess();
    return testing::AssertionFailure() << more << " more bytes were resident at the peak";
#endif
  }

 private:
  static std::int64_t status(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string word; file >> word;)
      if (std::int64_t kib = 0; word == name && file >> kib) return kib * 1024;
    return 0;
  }
  [[maybe_unused]] std::int64_t before_ = 0;
};

}  // namespace fracture::test
