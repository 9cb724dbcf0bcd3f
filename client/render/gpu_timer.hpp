// Measures the drawing time on the graphics card. The driver answers some frames later, and nothing waits for
// it.
#pragma once

#include <array>
#include <optional>

#include "client/render/gl_objects.hpp"

namespace fracture::render {

class GpuTimer {
 public:
  void begin();  ///< does nothing while too many answers are pending
  void end();
  /// Milliseconds of the oldest finished measurement that was not taken yet.
  std::optional<double> take();

 private:
  static constexpr std::size_t kAtOnce = 4;
  std::array<Query, kAtOnce> queries_;
  std::size_t next_ = 0, oldest_ = 0;  ///< number of measurements begun, and taken
  bool running_ = false;
};

}  // namespace fracture::render
