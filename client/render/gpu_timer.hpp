// What drawing takes where it is done: the driver answers some frames later, and nobody waits for it.
#pragma once

#include <array>
#include <optional>

#include "client/render/gl_objects.hpp"

namespace fracture::render {

class GpuTimer {
 public:
  void begin();  ///< nothing where the answers to earlier ones are still awaited
  void end();
  /// Milliseconds of the oldest measurement that is answered and was not taken yet.
  std::optional<double> take();

 private:
  static constexpr std::size_t kAtOnce = 4;
  std::array<Query, kAtOnce> queries_;
  std::size_t next_ = 0, oldest_ = 0;  ///< how many were begun, and taken
  bool running_ = false;
};

}  // namespace fracture::render
