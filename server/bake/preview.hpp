// Draws pictures of outputs with fracture-render in separate processes. Pictures are optional: if one fails,
// the bake reports it and continues.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "server/bake/renderer_process.hpp"

namespace fracture::bake {

struct PreviewSettings {
  std::string renderer{};  ///< program; empty: draw nothing, and use fitting pictures of earlier bakes
  int size = 256;          ///< width and height in pixels
  bool fine = false;       ///< smooth edges and soft shadows, in five times the time: for one picture
  int at_once = 1;         ///< maximum number of pictures drawn at once
  int threads = 0;         ///< per process, for drawing without a graphics card; 0: one per core
  std::chrono::milliseconds limit{60'000};  ///< for one picture
};

/// Thread-safe.
class Previews {
 public:
  /// `say` receives messages that concern all pictures.
  Previews(PreviewSettings settings, std::function<void(const std::string& line)> say);
  ~Previews();
  Previews(const Previews&) = delete;
  Previews& operator=(const Previews&) = delete;

  /// Draws `output` to `picture`, unless the existing picture has this size and is newer than the output.
  /// Returns the report's entry: {"file": picture}, with "warning" if drawing failed, or null if there is no
  /// picture and none was tried. `fresh`: the output was made in this run. `bytes`: the output's bytes if it
  /// is not a file.
  nlohmann::json of(const std::string& output, const std::string& picture, bool fresh,
                    std::span<const std::byte> bytes, const std::stop_token& stop);

  std::size_t drawn() const;
  std::size_t failed() const;

 private:
  Expected<void> draw(const std::string& output, const std::string& picture, std::span<const std::byte> bytes,
                      const std::stop_token& stop);
  Expected<void> draw_by_one(const nlohmann::json& line, const std::stop_token& stop);
  void note(bool good, bool renderer_failed);

  const PreviewSettings settings_;
  const std::function<void(const std::string& line)> say_;
  std::string folder_;  ///< for new pictures before they are checked; empty if it could not be created
  mutable std::mutex mutex_;
  std::condition_variable_any freed_;
  int busy_ = 0;
  struct Idle {
    std::unique_ptr<RendererProcess> process;
    std::size_t pictures = 0;
  };
  std::vector<Idle> idle_;
  std::size_t next_ = 0, drawn_ = 0, failed_ = 0;
  int failures_in_a_row_ = 0;  ///< failures of the renderer, not of single files
};

}  // namespace fracture::bake
