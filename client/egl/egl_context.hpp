// OpenGL without a window: an EGL context that draws into its own framebuffers. With Mesa (llvmpipe), it
// needs neither a display server nor a graphics card.
#pragma once

#include <memory>
#include <string>

#include "common/base/error.hpp"

namespace fracture::egl {

class EglContext {
 public:
  /// OpenGL 3.3 core without a surface, made current in this thread. Tries Mesa's surfaceless platform, then
  /// the devices that EGL lists, then the default display. kNoGraphics lists the reason for each of them.
  static Expected<EglContext> create();
  EglContext(EglContext&&) noexcept;
  EglContext& operator=(EglContext&&) noexcept;
  ~EglContext();

  const std::string& description() const;  ///< platform, renderer and version, for people

 private:
  struct State;
  explicit EglContext(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fracture::egl
