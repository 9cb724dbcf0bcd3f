// Reads scenes on another thread, because some take longer than a frame.
#pragma once

#include <functional>
#include <future>
#include <optional>

#include "client/app/background.hpp"
#include "client/scenes/scene.hpp"
#include "common/base/error.hpp"

namespace fracture::app {

/// The destructor waits for the scene that is being read.
class SceneLoader {
 public:
  using Loaded = Expected<scenes::Scene>;

  /// `background` must outlive this object.
  explicit SceneLoader(Background& background) : background_(background) {}

  /// Begins to read a scene. Drops the scene that is still being read, and waits for its end in the background.
  void begin(std::function<Loaded()> make);

  /// Returns the scene once, when it has been read; otherwise nothing.
  std::optional<Loaded> take();

 private:
  Background& background_;
  std::future<Loaded> loading_;
};

}  // namespace fracture::app
