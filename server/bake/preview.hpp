// Pictures of what was baked, drawn by fracture-render in processes of its own. A picture is an extra: whatever goes wrong
// with one is said, and the bake goes on.
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
  std::string
      renderer{};  ///< program; empty: none is drawn, and what earlier bakes drew is used as far as it fits
  int size = 256;  ///< pixels, of each side
  bool fine = false;  ///< smooth edges and soft shadows, in five times the time: for one picture
  int at_once = 1;    ///< further ones wait
  int threads = 0;    ///< of each process, where no graphics card draws; 0: one for each core
  std::chrono::milliseconds limit{60'000};  ///< for one picture
};

/// Thread-safe.
class Previews {
 public:
  /// `say` gets what concerns all of them.
  Previews(PreviewSettings settings, std::function<void(const std::string& line)> say);
  ~Previews();
  Previews(const Previews&) = delete;
  Previews& operator=(const Previews&) = delete;

  /// Draws `output` to `picture`, where the picture that lies there is not of this size, or older than the output. What the
  /// report says of it: {"file": picture}, with "warning" where it could not be drawn; null: there is none, and it was not
  /// tried. `fresh`: the output was made now. `bytes`: those of the output, for one that is no file.
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
  std::string folder_;  ///< of what is drawn and not yet looked at; empty: none could be made
  mutable std::mutex mutex_;
  std::condition_variable_any freed_;
  int busy_ = 0;
  struct Idle {
    std::unique_ptr<RendererProcess> process;
    std::size_t pictures = 0;
  };
  std::vector<Idle> idle_;
  std::size_t next_ = 0, drawn_ = 0, failed_ = 0;
  int failures_in_a_row_ = 0;  ///< of the renderer, not of a file
};

}  // namespace fracture::bake
