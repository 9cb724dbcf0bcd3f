#include "client/cli/draw_picture.hpp"

namespace fracture::cli {

Expected<PictureMaker> PictureMaker::create() {
  Expected<render::Renderer> renderer = render::Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  return PictureMaker(std::move(*renderer));
}

Expected<render::GpuScene*> PictureMaker::scene(const std::string& file) {
  constexpr std::size_t kKept = 4;  // the pictures of a row show two files or three
  const auto known = scenes_.find(file);
  if (known != scenes_.end()) return &known->second;
  if (scenes_.size() >= kKept) scenes_.clear();
  Expected<render::Scene> scene = render::load_scene(file);
  if (!scene) return tl::unexpected(scene.error());
  for (const std::string& warning : scene->warnings) warnings_.push_back(file + ": " + warning);
  Expected<render::GpuScene> gpu =
      render::GpuScene::upload(std::make_shared<const render::Scene>(std::move(*scene)));
  if (!gpu) return tl::unexpected(gpu.error());
  return &scenes_.emplace(file, std::move(*gpu)).first->second;
}

Expected<render::Picture> PictureMaker::draw(const PictureOptions& options) {
  const Expected<render::GpuScene*> gpu = scene(options.file);
  if (!gpu) return tl::unexpected(gpu.error());
  const int width = options.supersample * options.width, height = options.supersample * options.height;
  if (!target_ || target_->width() != width || target_->height() != height) {
    Expected<render::FrameTarget> target = render::FrameTarget::create(width, height);
    if (!target) return tl::unexpected(target.error());
    target_ = std::move(*target);
  }
  const render::Scene& scene = (*gpu)->scene();
  const std::vector<render::ObjectState> states = view_states(scene, options.view, options.camera);
  const render::Sphere sphere =
      options.frame == "assembled" ? (*gpu)->bounds() : bounding_sphere(scene, states);
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  stats_ = renderer_.draw(**gpu, states, fit_camera(sphere, options.camera, aspect), options.settings,
                          target_->framebuffer(), width, height);
  return downsample(target_->read(), options.supersample);
}

}  // namespace fracture::cli
