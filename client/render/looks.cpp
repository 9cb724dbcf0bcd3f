#include "client/render/looks.hpp"

#include <algorithm>
#include <string>

namespace fracture::render {
namespace {

/// Linear colours and roughness of outside and cut faces. If the solid texture sets the colour, these are its
/// mean.
struct LookValues {
  glm::vec3 outside, inside;
  float roughness_outside, roughness_inside, metallic, transmission_outside, transmission_inside;
};

constexpr LookValues values_of(SolidLook look) {
  switch (look) {
    case SolidLook::kGlass:
      return {{0.90f, 0.97f, 0.95f}, {0.55f, 0.86f, 0.78f}, 0.04f, 0.10f, 0, 0.96f, 0.80f};
    case SolidLook::kWood:
      return {{0.35f, 0.18f, 0.08f}, {0.62f, 0.42f, 0.23f}, 0.45f, 0.85f, 0, 0, 0};
    case SolidLook::kConcrete:
      return {{0.42f, 0.41f, 0.39f}, {0.36f, 0.34f, 0.31f}, 0.85f, 0.95f, 0, 0, 0};
    case SolidLook::kStone:
      return {{0.40f, 0.38f, 0.35f}, {0.50f, 0.48f, 0.45f}, 0.75f, 0.92f, 0, 0, 0};
    case SolidLook::kBrick:
      return {{0.42f, 0.13f, 0.07f}, {0.50f, 0.17f, 0.09f}, 0.85f, 0.95f, 0, 0, 0};
    case SolidLook::kCeramic:
      return {{0.10f, 0.25f, 0.38f}, {0.80f, 0.72f, 0.62f}, 0.12f, 0.85f, 0, 0, 0};
    case SolidLook::kMetal:
      return {{0.56f, 0.57f, 0.58f}, {0.70f, 0.69f, 0.68f}, 0.32f, 0.55f, 1, 0, 0};
    case SolidLook::kIce:
      return {{0.78f, 0.92f, 0.98f}, {0.88f, 0.96f, 1.00f}, 0.12f, 0.45f, 0, 0.75f, 0.35f};
    default:
      return {{0.75f, 0.73f, 0.70f}, {0.74f, 0.71f, 0.66f}, 0.80f, 0.95f, 0, 0, 0};
  }
}

/// Grey of the same brightness (the luminance of linear sRGB, IEC 61966-2-1).
glm::vec4 grey_of(const glm::vec4& color) {
  const float luminance = 0.2126f * color.r + 0.7152f * color.g + 0.0722f * color.b;
  return {luminance, luminance, luminance, color.a};
}

Material without_color(const Material& source) {
  Material m = source;
  m.base_color_texture = m.metallic_roughness_texture = m.emissive_texture = {};
  m.emissive = {};
  if (source.interior) {
    m.base_color = grey_of(source.base_color);
    return m;
  }
  m.base_color = {0.5f, 0.5f, 0.5f, source.base_color.a};
  m.normal_texture = m.occlusion_texture = {};
  return m;
}

}  // namespace

Expected<SolidLook> look_by_name(std::string_view name) {
  const auto found = std::find(kLookNames.begin(), kLookNames.end(), name);
  if (found != kLookNames.end()) return static_cast<SolidLook>(found - kLookNames.begin());
  std::string known;
  for (const std::string_view look : kLookNames) known += (known.empty() ? "" : ", ") + std::string(look);
  return fail(ErrorCode::kBadParameter, "There is no look '" + std::string(name) + "' (" + known + ").");
}

Material with_look(const Material& source, SolidLook look) {
  if (look == SolidLook::kNone) return source;
  if (look == SolidLook::kGrey) return without_color(source);
  const LookValues v = values_of(look);
  Material m;
  m.name = source.name;
  m.interior = source.interior;
  m.base_color = glm::vec4(source.interior ? v.inside : v.outside, 1);
  m.roughness = source.interior ? v.roughness_inside : v.roughness_outside;
  m.metallic = v.metallic;
  m.transmission = source.interior ? v.transmission_inside : v.transmission_outside;
  m.ior = look == SolidLook::kIce ? 1.31f : 1.5f;
  return m;
}

}  // namespace fracture::render
