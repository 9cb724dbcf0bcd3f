#include "common/surface_color/base_color.hpp"
#include "common/mesh/material_library.hpp"

#include <algorithm>
#include <cmath>

namespace fracture {
namespace {

using nlohmann::json;

/// The member, or a JSON null if it does not exist.
const json& member(const json& value, const char* name) {
  static const json nothing;
  if (!value.is_object()) return nothing;
  const auto it = value.find(name);
  return it == value.end() ? nothing : *it;
}

double finite_or(const json& value, double otherwise) {
  const double number = value.is_number() ? value.get<double>() : otherwise;
  return std::isfinite(number) ? number : otherwise;
}

std::uint64_t index_or(const json& value, std::uint64_t otherwise) {
  const bool index =
      value.is_number_unsigned() || (value.is_number_integer() && value.get<std::int64_t>() >= 0);
  return index ? value.get<std::uint64_t>() : otherwise;
}

std::array<double, 2> pair_or(const json& value, std::array<double, 2> otherwise) {
  if (!value.is_array() || value.size() != 2) return otherwise;
  return {finite_or(value[0], otherwise[0]), finite_or(value[1], otherwise[1])};
}

Wrap wrap_of(const json& value) {
  switch (index_or(value, 10497)) {
    case 33071:
      return Wrap::kClamp;
    case 33648:
      return Wrap::kMirror;
    default:
      return Wrap::kRepeat;
  }
}

/// Rounds, because the last bits of sin() and cos() differ between C libraries.
double rounded(double x) { return std::nearbyint(x * 1e9) / 1e9; }

void read_transform(const json& transform, BaseColorTexture& texture) {
  if (!transform.is_object()) return;
  texture.uv_set = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(index_or(member(transform, "texCoord"), texture.uv_set), kNoIndex));
  const auto [dx, dy] = pair_or(member(transform, "offset"), {0, 0});
  const auto [sx, sy] = pair_or(member(transform, "scale"), {1, 1});
  const double angle = finite_or(member(transform, "rotation"), 0);
  const double c = rounded(std::cos(angle)), s = rounded(std::sin(angle));
  texture.transform = {{{c * sx, s * sy, dx}, {-s * sx, c * sy, dy}}};
}

std::optional<BaseColorTexture> texture_of(const MaterialLibrary& library, const json& reference) {
  const std::uint64_t index = index_or(member(reference, "index"), library.textures.size());
  if (index >= library.textures.size()) return std::nullopt;
  const json& texture = library.textures[index];
  const std::uint64_t none = library.images.size();
  std::uint64_t image = index_or(member(texture, "source"), none);
  if (image >= none && member(texture, "extensions").is_object())  // such as KHR_texture_basisu
    for (const auto& [name, extension] : texture["extensions"].items())
      image = std::min(image, index_or(member(extension, "source"), none));
  if (image >= none) return std::nullopt;
  BaseColorTexture found;
  found.image = static_cast<std::uint32_t>(image);
  found.uv_set = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(index_or(member(reference, "texCoord"), 0), kNoIndex));
  if (const std::uint64_t sampler = index_or(member(texture, "sampler"), library.samplers.size());
      sampler < library.samplers.size())
    found.wrap = {wrap_of(member(library.samplers[sampler], "wrapS")),
                  wrap_of(member(library.samplers[sampler], "wrapT"))};
  read_transform(member(member(reference, "extensions"), "KHR_texture_transform"), found);
  return found;
}

}  // namespace

std::uint32_t wrapped(double coordinate, Wrap wrap, std::uint32_t pixels) {
  double within = coordinate;
  if (wrap == Wrap::kRepeat) within = coordinate - std::floor(coordinate);
  if (wrap == Wrap::kMirror) {
    within = coordinate - 2 * std::floor(coordinate / 2);
    if (within > 1) within = 2 - within;
  }
  const double pixel = within * pixels;
  return pixel > 0 ? static_cast<std::uint32_t>(std::fmin(pixel, pixels - 1.0)) : 0;  // also for NaN
}

std::array<double, 2> BaseColorTexture::place(const Vec2f& uv) const {
  std::array<double, 2> place;
  for (std::size_t k = 0; k < 2; ++k)
    place[k] = transform[k][0] * uv.x + transform[k][1] * uv.y + transform[k][2];
  return place;
}

BaseColor base_color(const MaterialLibrary& library, std::size_t material) {
  BaseColor color;
  if (material >= library.materials.size()) return color;
  const json& source = library.materials[material];
  const json& glossy = member(member(source, "extensions"), "KHR_materials_pbrSpecularGlossiness");
  const bool specular = glossy.is_object();
  const json& pbr = specular ? glossy : member(source, "pbrMetallicRoughness");
  if (const json& factor = member(pbr, specular ? "diffuseFactor" : "baseColorFactor");
      factor.is_array() && factor.size() >= 3)
    for (int k = 0; k < 3; ++k) color.factor[k] = std::clamp(finite_or(factor[k], 1), 0.0, 1.0);
  color.texture = texture_of(library, member(pbr, specular ? "diffuseTexture" : "baseColorTexture"));
  const json& mode = member(source, "alphaMode");
  color.weigh_opacity = mode == "MASK" || mode == "BLEND";
  color.translucent =
      mode == "BLEND" || finite_or(member(member(member(source, "extensions"), "KHR_materials_transmission"),
                                          "transmissionFactor"),
                                   0) > 0;
  return color;
}

}  // namespace fracture
