#include "common/import/assimp_materials.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/import/file_textures.hpp"
#include "common/import/text_encoding.hpp"

namespace fracture {
namespace {

using nlohmann::json;

double unit_interval(float value) {
  return std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, 1.0) : 1.0;
}

/// Rounds to a few decimal digits, because Assimp's floats have no more, and 0.8 must not become
/// 0.800000011920929.
double short_number(float value) { return std::round(unit_interval(value) * 1e6) / 1e6; }

/// The bytes of an image inside the scene; empty if it is in another file.
std::span<const std::uint8_t> embedded_image(const aiScene& scene, const std::string& path) {
  const aiTexture* embedded = scene.GetEmbeddedTexture(path.c_str());
  if (embedded == nullptr || embedded->mHeight != 0) return {};
  return {reinterpret_cast<const std::uint8_t*>(embedded->pcData), embedded->mWidth};
}

json translate(const aiMaterial& source, const aiScene& scene, FileTextures& textures) {
  json material = json::object();
  aiString name;
  if (source.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS && name.length > 0)
    material["name"] = name_as_utf8(name.C_Str());
  json pbr = {{"metallicFactor", 0}};
  aiColor4D color(1, 1, 1, 1);
  if (source.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS) source.Get(AI_MATKEY_COLOR_DIFFUSE, color);
  float opacity = 1;
  source.Get(AI_MATKEY_OPACITY, opacity);
  const double alpha = short_number(opacity);
  pbr["baseColorFactor"] = {short_number(color.r), short_number(color.g), short_number(color.b), alpha};
  if (alpha < 1) material["alphaMode"] = "BLEND";
  float value = 0;
  if (source.Get(AI_MATKEY_METALLIC_FACTOR, value) == aiReturn_SUCCESS)
    pbr["metallicFactor"] = short_number(value);
  if (source.Get(AI_MATKEY_ROUGHNESS_FACTOR, value) == aiReturn_SUCCESS) {
    pbr["roughnessFactor"] = short_number(value);
  } else if (source.Get(AI_MATKEY_SHININESS, value) == aiReturn_SUCCESS && std::isfinite(value) &&
             value > 0) {
    // Blinn-Phong exponent n to roughness: alpha = roughness^2 = sqrt(2 / (n + 2)) (Walter et al. 2007).
    pbr["roughnessFactor"] =
        short_number(static_cast<float>(std::sqrt(std::sqrt(2.0 / (static_cast<double>(value) + 2.0)))));
  }
  aiColor3D emissive(0, 0, 0);
  if (source.Get(AI_MATKEY_COLOR_EMISSIVE, emissive) == aiReturn_SUCCESS &&
      (emissive.r > 0 || emissive.g > 0 || emissive.b > 0))
    material["emissiveFactor"] = {short_number(emissive.r), short_number(emissive.g),
                                  short_number(emissive.b)};
  int two_sided = 0;
  if (source.Get(AI_MATKEY_TWOSIDED, two_sided) == aiReturn_SUCCESS && two_sided != 0)
    material["doubleSided"] = true;

  const auto texture_of = [&](aiTextureType type) {
    aiString path;
    if (source.GetTexture(type, 0, &path) != aiReturn_SUCCESS || path.length == 0) return kNoIndex;
    return textures.texture(path.C_Str(), embedded_image(scene, path.C_Str()));
  };
  std::uint32_t base = texture_of(aiTextureType_BASE_COLOR);
  if (base == kNoIndex) base = texture_of(aiTextureType_DIFFUSE);
  if (base != kNoIndex) pbr["baseColorTexture"] = {{"index", base}};
  std::uint32_t normal = texture_of(aiTextureType_NORMALS);
  if (normal == kNoIndex) normal = texture_of(aiTextureType_NORMAL_CAMERA);
  if (normal != kNoIndex) material["normalTexture"] = {{"index", normal}};
  if (const std::uint32_t glow = texture_of(aiTextureType_EMISSIVE); glow != kNoIndex) {
    material["emissiveTexture"] = {{"index", glow}};
    if (!material.contains("emissiveFactor")) material["emissiveFactor"] = {1, 1, 1};
  }
  material["pbrMetallicRoughness"] = std::move(pbr);
  return material;
}

}  // namespace

TranslatedMaterials translate_materials(const aiScene& scene, std::span<const ImportFile> files) {
  TranslatedMaterials out;
  FileTextures textures(files, out.library, out.remarks);
  for (unsigned k = 0; k < scene.mNumMaterials; ++k) {
    aiString name;
    scene.mMaterials[k]->Get(AI_MATKEY_NAME, name);
    if (std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME) {  // Assimp's placeholder for "no material"
      out.slot.push_back(kNoIndex);
      continue;
    }
    out.slot.push_back(static_cast<std::uint32_t>(out.library.materials.size()));
    out.library.materials.push_back(translate(*scene.mMaterials[k], scene, textures));
  }
  return out;
}

}  // namespace fracture
