// Work that no frame waits for: writing files and ending games.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "client/game/recording.hpp"
#include "client/render/image.hpp"

namespace fracture::app {

/// Runs tasks in the background. The destructor waits for all of them.
class Background {
 public:
  void run(std::function<void()> work);
  /// Destroys `old` in the background.
  template <class T>
  void retire(std::unique_ptr<T> old) {
    if (old) run([old = std::shared_ptr<T>(std::move(old))]() mutable { old.reset(); });
  }

  // If a file cannot be written, an error is printed on stderr.
  void write_picture(std::shared_ptr<const render::Picture> picture, const std::string& path);
  void write_bytes(std::shared_ptr<const std::string> bytes, const std::string& path);
  /// Writes the recording once it is ready.
  void write_recording(std::future<game::Recording> recording, const std::string& path);

 private:
  std::vector<std::future<void>> working_;
};

}  // namespace fracture::app
