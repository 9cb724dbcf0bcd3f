// How much more memory than before this process has had resident at its peak.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

namespace fracture::test {

class PeakMemory {
 public:
  PeakMemory() {
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak begins anew (proc(5))
    before_ = status("VmRSS:");
  }
  std::int64_t more_bytes() const { return status("VmHWM:") - before_; }

 private:
  static std::int64_t status(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string word; file >> word;)
      if (std::int64_t kib = 0; word == name && file >> kib) return kib * 1024;
    return 0;
  }
  std::int64_t before_ = 0;
};

}  // namespace fracture::test
