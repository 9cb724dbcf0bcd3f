// Work that no frame waits for: files that are written, games that end.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "client/game/recording.hpp"
#include "client/render/image.hpp"

namespace fracture::app {

/// Its end waits for all of it.
class Background {
 public:
  void run(std::function<void()> work);
  /// Destroys it there.
  template <class T>
  void retire(std::unique_ptr<T> old) {
    if (old) run([old = std::shared_ptr<T>(std::move(old))]() mutable { old.reset(); });
  }

  // What cannot be written is said on stderr.
  void write_picture(std::shared_ptr<const render::Picture> picture, const std::string& path);
  void write_bytes(std::shared_ptr<const std::string> bytes, const std::string& path);
  /// When it is there.
  void write_recording(std::future<game::Recording> recording, const std::string& path);

 private:
  std::vector<std::future<void>> working_;
};

}  // namespace fracture::app
