#include "client/render/read_materials.hpp"
#include "common/mesh/material_library.hpp"

#include <algorithm>
#include <set>

namespace fracture::render {
namespace {

using nlohmann::json;

const json kNothing = json::object();

const json& child(const json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_object() ? *it : kNothing;
}

float number(const json& object, const char* key, float fallback, float low, float high) {
  const auto it = object.find(key);
  return it == object.end() ? fallback : std::clamp(it->get<float>(), low, high);
}

template <int N>
glm::vec<N, float> vector(const json& object, const char* key, glm::vec<N, float> fallback) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array() || it->size() != N) return fallback;
  for (int k = 0; k < N; ++k) fallback[k] = (*it)[static_cast<std::size_t>(k)].get<float>();
  return fallback;
}

TextureSlot slot(const json& material, const char* key, const MaterialLibrary& library, Model& model) {
  TextureSlot result;
  const json& info = child(material, key);
  const auto index = info.value("index", std::uint64_t{kNoSlot});
  if (index >= library.textures.size()) return result;
  const json& texture = library.textures[index];
  const auto source = texture.value("source", std::uint64_t{kNoSlot});
  if (source >= library.images.size()) {
    model.warnings.push_back(std::string("A ") + key + " has no PNG or JPEG image, so it is ignored.");
    return result;
  }
  result.picture = static_cast<std::uint32_t>(source);
  result.uv_set = info.value("texCoord", 0);
  if (result.uv_set < 0 || result.uv_set > 1) {
    model.warnings.push_back(std::string("A ") + key + " uses TEXCOORD_" + std::to_string(result.uv_set) +
                             "; TEXCOORD_0 is used instead.");
    result.uv_set = 0;
  }
  if (const auto sampler = texture.value("sampler", std::uint64_t{kNoSlot});
      sampler < library.samplers.size()) {
    const json& s = library.samplers[sampler];
    const auto choose = [&](const char* name, int fallback, std::initializer_list<int> legal) {
      const int value = s.value(name, fallback);
      return std::find(legal.begin(), legal.end(), value) != legal.end() ? value : fallback;
    };
    result.min_filter = choose("minFilter", 9987, {9728, 9729, 9984, 9985, 9986, 9987});
    result.mag_filter = choose("magFilter", 9729, {9728, 9729});
    result.wrap_s = choose("wrapS", 10497, {33071, 33648, 10497});
    result.wrap_t = choose("wrapT", 10497, {33071, 33648, 10497});
  }
  return result;
}

Material read_material(const json& source, const MaterialLibrary& library, Model& model) {
  Material m;
  m.name = source.value("name", "");
  const json& pbr = child(source, "pbrMetallicRoughness");
  m.base_color = vector<4>(pbr, "baseColorFactor", glm::vec4(1));
  m.metallic = number(pbr, "metallicFactor", 1, 0, 1);
  m.roughness = number(pbr, "roughnessFactor", 1, 0, 1);
  m.emissive = vector<3>(source, "emissiveFactor", glm::vec3(0));
  m.alpha_cutoff = number(source, "alphaCutoff", 0.5f, 0, 1);
  m.double_sided = source.value("doubleSided", false);
  const std::string mode = source.value("alphaMode", "OPAQUE");
  m.alpha_mode = mode == "MASK" ? AlphaMode::kMask : mode == "BLEND" ? AlphaMode::kBlend : AlphaMode::kOpaque;
  m.base_color_texture = slot(pbr, "baseColorTexture", library, model);
  m.metallic_roughness_texture = slot(pbr, "metallicRoughnessTexture", library, model);
  m.normal_texture = slot(source, "normalTexture", library, model);
  m.normal_scale = number(child(source, "normalTexture"), "scale", 1, -8, 8);
  m.occlusion_texture = slot(source, "occlusionTexture", library, model);
  m.occlusion_strength = number(child(source, "occlusionTexture"), "strength", 1, 0, 1);
  m.emissive_texture = slot(source, "emissiveTexture", library, model);
  const json& extensions = child(source, "extensions");
  m.transmission = number(child(extensions, "KHR_materials_transmission"), "transmissionFactor", 0, 0, 1);
  m.ior = number(child(extensions, "KHR_materials_ior"), "ior", 1.5f, 1, 4);
  m.emissive *= number(child(extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1, 0, 1e4f);
  return m;
}

}  // namespace

void read_materials(const MaterialLibrary& library, Model& model) {
  for (const json& material : library.materials)
    model.materials.push_back(read_material(material, library, model));
  model.materials.push_back({});  // glTF 2.0, 3.9: for primitives without a material
  for (const Image& image : library.images) {
    Expected<Picture> picture = decode_picture(image.bytes);
    if (!picture)
      model.warnings.push_back("Image \"" + image.name.substr(0, 60) + "\" (" + image.mime_type +
                               ") is shown in grey. " + picture.error().detail);
    model.pictures.push_back(picture ? std::move(*picture) : Picture(1, 1, {128, 128, 128, 255}));
  }
  const std::set<std::string> known = {"KHR_materials_transmission", "KHR_materials_ior",
                                       "KHR_materials_emissive_strength",
                                       "KHR_materials_variants"};  // the default materials are shown
  for (const std::string& name : library.extensions_used)
    if (known.count(name) == 0) model.warnings.push_back("The extension " + name + " is not supported.");
}

}  // namespace fracture::render
