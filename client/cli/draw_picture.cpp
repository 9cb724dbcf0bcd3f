#include "client/cli/draw_picture.hpp"

namespace fracture::cli {

Expected<PictureMaker> PictureMaker::create() {
  Expected<render::Renderer> renderer = render::Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  return PictureMaker(std::move(*renderer));
}

Expected<render::GpuModel*> PictureMaker::model(const std::string& file) {
  constexpr std::size_t kKept = 4;  // the pictures of a row show two or three files
  const auto known = scenes_.find(file);
  if (known != scenes_.end()) return &known->second;
  if (scenes_.size() >= kKept) scenes_.clear();
  Expected<render::Model> model = render::load_model(file);
  if (!model) return tl::unexpected(model.error());
  for (const std::string& warning : model->warnings) warnings_.push_back(file + ": " + warning);
  Expected<render::GpuModel> gpu =
      render::GpuModel::upload(std::make_shared<const render::Model>(std::move(*model)));
  if (!gpu) return tl::unexpected(gpu.error());
  return &scenes_.emplace(file, std::move(*gpu)).first->second;
}

Expected<render::Picture> PictureMaker::draw(const PictureOptions& options) {
  const Expected<render::GpuModel*> gpu = model(options.file);
  if (!gpu) return tl::unexpected(gpu.error());
  const int width = options.supersample * options.width, height = options.supersample * options.height;
  if (!target_ || target_->width() != width || target_->height() != height) {
    Expected<render::FrameTarget> target = render::FrameTarget::create(width, height);
    if (!target) return tl::unexpected(target.error());
    target_ = std::move(*target);
  }
  const render::Model& model = (*gpu)->model();
  const std::vector<render::ObjectState> states = view_states(model, options.view, options.camera);
  const render::Sphere sphere =
      options.frame == "assembled" ? (*gpu)->bounds() : bounding_sphere(model, states);
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  stats_ = renderer_.draw(**gpu, states, fit_camera(sphere, options.camera, aspect), options.settings,
                          target_->framebuffer(), width, height);
  if (stats_.tier != options.settings.tier && renderer_.trouble())
    return tl::unexpected(*renderer_.trouble());
  return downsample(target_->read(), options.supersample);
}

}  // namespace fracture::cli
