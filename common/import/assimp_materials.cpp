#include "common/import/assimp_materials.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>

#include "common/import/file_textures.hpp"
#include "common/import/plain_materials.hpp"

namespace fracture {
namespace {

PlainMaterial plain_from_assimp(const aiMaterial& source) {
  PlainMaterial material;
  aiString name;
  if (source.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) material.name = name.C_Str();
  aiColor4D color(1, 1, 1, 1);
  if (source.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS) source.Get(AI_MATKEY_COLOR_DIFFUSE, color);
  material.color = {color.r, color.g, color.b};
  source.Get(AI_MATKEY_OPACITY, material.opacity);
  float value = 0;
  if (source.Get(AI_MATKEY_METALLIC_FACTOR, value) == aiReturn_SUCCESS) material.metallic = value;
  if (source.Get(AI_MATKEY_ROUGHNESS_FACTOR, value) == aiReturn_SUCCESS) material.roughness = value;
  if (source.Get(AI_MATKEY_SHININESS, value) == aiReturn_SUCCESS) material.shininess = value;
  aiColor3D emission(0, 0, 0);
  if (source.Get(AI_MATKEY_COLOR_EMISSIVE, emission) == aiReturn_SUCCESS)
    material.emission = {emission.r, emission.g, emission.b};
  int two_sided = 0;
  material.two_sided = source.Get(AI_MATKEY_TWOSIDED, two_sided) == aiReturn_SUCCESS && two_sided != 0;
  const auto add_map = [&source](std::vector<std::string>& maps, aiTextureType type) {
    aiString path;
    if (source.GetTexture(type, 0, &path) == aiReturn_SUCCESS && path.length > 0)
      maps.emplace_back(path.C_Str());
  };
  add_map(material.color_maps, aiTextureType_BASE_COLOR);
  add_map(material.color_maps, aiTextureType_DIFFUSE);
  add_map(material.normal_maps, aiTextureType_NORMALS);
  add_map(material.normal_maps, aiTextureType_NORMAL_CAMERA);
  add_map(material.emission_maps, aiTextureType_EMISSIVE);
  return material;
}

}  // namespace

TranslatedMaterials translate_materials(const aiScene& scene, std::span<const ImportFile> files) {
  TranslatedMaterials out;
  FileTextures textures(files, out.library, out.remarks, out.dropped);
  const auto find_texture = [&](const std::string& path) {
    const aiTexture* embedded = scene.GetEmbeddedTexture(path.c_str());
    if (embedded == nullptr || embedded->mHeight != 0) return textures.texture(path);
    return textures.texture(path,
                            {reinterpret_cast<const std::uint8_t*>(embedded->pcData), embedded->mWidth});
  };
  for (unsigned k = 0; k < scene.mNumMaterials; ++k) {
    aiString name;
    scene.mMaterials[k]->Get(AI_MATKEY_NAME, name);
    if (std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME) {  // Assimp's placeholder for "no material"
      out.slot.push_back(kNoIndex);
      continue;
    }
    out.slot.push_back(static_cast<std::uint32_t>(out.library.materials.size()));
    out.library.materials.push_back(to_gltf(plain_from_assimp(*scene.mMaterials[k]), find_texture));
  }
  return out;
}

}  // namespace fracture
