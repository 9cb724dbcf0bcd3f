// Draws a picture from its options: loads the file, fits the camera, draws and reads the pixels back.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/picture_options.hpp"
#include "client/render/frame_target.hpp"

namespace fracture::cli {

/// Keeps what the next picture may need again: the renderer, the last target and the last few models.
class PictureMaker {
 public:
  /// A context must be current.
  static Expected<PictureMaker> create();

  Expected<render::Picture> draw(const PictureOptions& options);

  /// Drops the models and warnings so far, so that a file of the same name is read again.
  void forget() {
    scenes_.clear();
    warnings_.clear();
  }

  const render::FrameStats& stats() const { return stats_; }  ///< of the last picture
  const std::vector<std::string>& warnings() const {
    return warnings_;
  }  ///< of all files so far, with the file names

 private:
  explicit PictureMaker(render::Renderer renderer) : renderer_(std::move(renderer)) {}
  Expected<render::GpuModel*> model(const std::string& file);

  render::Renderer renderer_;
  std::optional<render::FrameTarget> target_;
  std::map<std::string, render::GpuModel> scenes_;
  render::FrameStats stats_;
  std::vector<std::string> warnings_;
};

}  // namespace fracture::cli
