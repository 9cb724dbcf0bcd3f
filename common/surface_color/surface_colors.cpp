#include "common/surface_color/surface_colors.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/base_color.hpp"
#include "common/surface_color/mean_pyramid.hpp"
#include "common/surface_color/pixels.hpp"

namespace fracture {
namespace {

/// Decides whether images may be decoded, by their pixels counted so far.
class PixelBudget {
 public:
  PixelBudget(const MaterialLibrary& library, const PixelLimits& limits) {
    std::uint64_t bytes = 0;
    for (const Image& image : library.images) bytes += image.bytes.size();
    left_ = std::min(limits.most, limits.any + limits.per_byte * bytes);
    of_one_ = limits.of_one;
  }
  bool take(std::uint64_t pixels) {
    if (pixels > std::min(left_, of_one_)) return false;
    left_ -= pixels;
    return true;
  }

 private:
  std::uint64_t left_, of_one_;
};

/// Points on a triangle, as weights of its corners: the middles of n² equal triangles.
using Barycentric = std::array<double, 3>;

std::vector<Barycentric> middles(int n) {
  std::vector<Barycentric> places;
  const double third = 1.0 / 3;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      const auto add = [&](double a, double b) { places.push_back({a / n, b / n, 1 - (a + b) / n}); };
      add(i + third, j + third);
      if (i + j + 1 < n) add(i + 2 * third, j + 2 * third);
    }
  return places;
}

/// The mean of a texture over triangles.
class TextureMean {
 public:
  TextureMean(const MeanPyramid& pyramid, const BaseColorTexture& texture, const std::vector<Vec2f>& uvs)
      : pyramid_(pyramid), texture_(texture), uvs_(uvs) {}

  /// Linear, each component 0 … 1.
  Vec3d over(const std::array<std::uint32_t, 3>& wedges) const {
    std::array<std::array<double, 2>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = texture_.place(uvs_[wedges[k]]);
    const double pixels = std::fabs((corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                                    (corners[1][1] - corners[0][1]) * (corners[2][0] - corners[0][0])) /
                          2 * pyramid_.width() * pyramid_.height();
    const std::vector<Barycentric>& places = places_[pixels > 16 ? 3 : pixels > 4 ? 2 : pixels > 1 ? 1 : 0];
    // Level pixels cover at most 1/16 of a place's share of the triangle; larger ones would extend beyond it.
    std::size_t level = 0;
    for (double left = 16 * static_cast<double>(places.size());
         left * 4 <= pixels && level + 1 < pyramid_.levels(); left *= 4)
      ++level;
    double sum[3] = {}, weights = 0;
    for (const Barycentric& b : places) {
      std::uint32_t at[2];
      for (std::size_t k = 0; k < 2; ++k)
        at[k] = wrapped(b[0] * corners[0][k] + b[1] * corners[1][k] + b[2] * corners[2][k], texture_.wrap[k],
                        k == 0 ? pyramid_.width() : pyramid_.height());
      const MeanPyramid::Texel texel = pyramid_.over(level, at[0], at[1]);
      for (std::size_t k = 0; k < 3; ++k) sum[k] += 1.0 * texel.color[k] * texel.weight;
      weights += texel.weight;
    }
    return (1 / (weights * 65535)) * Vec3d{sum[0], sum[1], sum[2]};
  }

 private:
  const MeanPyramid& pyramid_;
  const BaseColorTexture& texture_;
  const std::vector<Vec2f>& uvs_;
  const std::array<std::vector<Barycentric>, 4> places_{middles(1), middles(2), middles(4), middles(8)};
};

/// The mean of the vertex colours; white where there are none.
Vec3d vertex_color(const Mesh& mesh, const std::array<std::uint32_t, 3>& wedges) {
  if (mesh.attributes.colors.empty()) return {1, 1, 1};
  const std::vector<Vec4f>& colors = mesh.attributes.colors[0];
  Vec3d sum;
  for (const std::uint32_t w : wedges) sum = sum + Vec3d{colors[w].x, colors[w].y, colors[w].z};
  return (1.0 / 3) * sum;
}

SurfaceColor product(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  SurfaceColor color{{}, 1};
  for (int k = 0; k < 3; ++k)
    color.light[k] =
        static_cast<std::uint16_t>(std::nearbyint(65535 * std::clamp(a[k] * b[k] * c[k], 0.0, 1.0)));
  return color;
}

/// Materials that use one image with the same options share a key, so the image is decoded once.
using ImageUse = std::pair<std::uint32_t, bool>;  // image, weigh_opacity

/// Names the material, because many images have no name.
std::string name_of(const MaterialLibrary& library, std::uint32_t material) {
  const auto name = library.materials[material].find("name");
  if (name == library.materials[material].end() || !name->is_string() ||
      name->get_ref<const std::string&>().empty())
    return "material " + std::to_string(material);
  return "the material \"" + shortened(name->get_ref<const std::string&>()) + "\"";
}

/// `material`: the first one that uses the image.
std::optional<Pixels> pixels_of(const Image& image, const std::string& material, PixelBudget& budget,
                                Remarks& remarks) {
  const std::optional<std::uint64_t> count = pixel_count(image.bytes);
  const bool small = count && budget.take(*count);
  std::optional<Pixels> pixels;
  if (small) pixels = decode_image(image.bytes);
  const std::string name = image.name.empty() ? "" : " \"" + shortened(image.name) + "\"";
  if (!pixels && small)
    remarks.warn(
        "The image" + name + " of " + material +
        " is damaged. The answer contains it unchanged, and cut faces take no colour from it. Export "
        "it again.");
  else if (!pixels)
    remarks.note("Cut faces take no colour from the image" + name + " of " + material + ", because it " +
                 (count ? "has too many pixels (" + grouped(*count) + ")" : why_unread(image.bytes)) +
                 ". Use 'interior_color' to give them one.");
  return pixels;
}

class Painter {
 public:
  explicit Painter(const Mesh& mesh) : mesh_(mesh), triangles_of_(mesh.library->materials.size()) {
    for (std::uint32_t k = 0; k < triangles_of_.size(); ++k) {
      colors_.push_back(base_color(*mesh.library, k));
      if (const auto& texture = colors_.back().texture)
        materials_of_[{texture->image, colors_.back().weigh_opacity}].push_back(k);
    }
  }

  std::vector<SurfaceColor> run(Remarks& remarks, const PixelLimits& limits) {
    paint_without_images();
    PixelBudget budget(*mesh_.library, limits);
    for (const auto& [use, slots] : materials_of_) {
      const auto first =
          std::find_if(slots.begin(), slots.end(), [&](auto slot) { return !triangles_of_[slot].empty(); });
      if (first == slots.end()) continue;
      std::optional<Pixels> pixels =
          pixels_of(mesh_.library->images[use.first], name_of(*mesh_.library, *first), budget, remarks);
      if (!pixels) continue;
      const MeanPyramid pyramid(std::move(*pixels), use.second);
      for (const std::uint32_t slot : slots) paint(slot, pyramid);
    }
    const bool any =
        std::any_of(result_.begin(), result_.end(), [](const SurfaceColor& c) { return c.known != 0; });
    return any ? std::move(result_) : std::vector<SurfaceColor>();
  }

 private:
  void paint_without_images() {
    result_.resize(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < result_.size(); ++t) {
      const std::uint32_t slot = mesh_.material[t];
      const bool material = slot < colors_.size();
      if (material && colors_[slot].texture) {
        triangles_of_[slot].push_back(t);
      } else if (material || !mesh_.attributes.colors.empty()) {
        result_[t] = product(material ? colors_[slot].factor : Vec3d{1, 1, 1},
                             vertex_color(mesh_, mesh_.triangles[t]), {1, 1, 1});
      }
    }
  }

  void paint(std::uint32_t slot, const MeanPyramid& pyramid) {
    const BaseColor& color = colors_[slot];
    if (color.texture->uv_set >= mesh_.attributes.uvs.size()) return;
    const TextureMean mean(pyramid, *color.texture, mesh_.attributes.uvs[color.texture->uv_set]);
    for (const std::uint32_t t : triangles_of_[slot])
      result_[t] =
          product(color.factor, vertex_color(mesh_, mesh_.triangles[t]), mean.over(mesh_.triangles[t]));
  }

  const Mesh& mesh_;
  std::vector<BaseColor> colors_;  ///< for each material
  std::map<ImageUse, std::vector<std::uint32_t>> materials_of_;
  std::vector<std::vector<std::uint32_t>> triangles_of_;  ///< for each material with a texture
  std::vector<SurfaceColor> result_;
};

}  // namespace

std::vector<SurfaceColor> surface_colors(const Mesh& mesh, Remarks& remarks, const PixelLimits& limits) {
  return Painter(mesh).run(remarks, limits);
}

}  // namespace fracture
