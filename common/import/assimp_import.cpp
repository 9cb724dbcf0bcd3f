#include "common/import/assimp_import.hpp"

#include <assimp/BaseImporter.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/import/assimp_files.hpp"
#include "common/import/assimp_materials.hpp"
#include "common/import/assimp_polygons.hpp"
#include "common/import/file_positions.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/transform.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

/// Leaves only the reader of this format registered. Unregistering does not delete readers, so this function
/// does.
void keep_only(Assimp::Importer& importer, const std::string& extension) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t k = 0; k < importer.GetImporterCount(); ++k) {
    std::set<std::string> extensions;
    importer.GetImporter(k)->GetExtensionList(extensions);
    if (extensions.count(extension) == 0) others.push_back(importer.GetImporter(k));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
}

/// The name of the main file for Assimp, whose readers depend on the file extension.
std::string main_name(MeshFormat format, std::span<const ImportFile> files) {
  if (format == MeshFormat::kXml) return "mesh.mesh.xml";  // a mesh of Ogre; see preflight::kind_of_xml
  if (format == MeshFormat::k3d) {  // Unreal stores vertices and their animation in a pair of files
    const bool animation = std::any_of(files.begin(), files.end(),
                                       [](const ImportFile& f) { return f.name.ends_with("_d.3d"); });
    return animation ? "mesh_a.3d" : "mesh_d.3d";
  }
  return "mesh." + std::string(extension_of(format));
}

Transform to_transform(const aiMatrix4x4& m) {
  return {{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}, {m.a4, m.b4, m.c4}};
}

/// Checks indices before Assimp's post-processing uses them.
void check_indices(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    if ((mesh.mVertices == nullptr && mesh.mNumVertices > 0) ||
        (mesh.mFaces == nullptr && mesh.mNumFaces > 0))
      refuse(ErrorCode::kMalformedMesh, "Mesh " + std::to_string(m) + " has faces but no vertices.");
    for (unsigned f = 0; f < mesh.mNumFaces; ++f)
      for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k)
        if (mesh.mFaces[f].mIndices[k] >= mesh.mNumVertices)
          refuse(ErrorCode::kMalformedMesh, "Face " + std::to_string(f) + " refers to vertex " +
                                                std::to_string(mesh.mFaces[f].mIndices[k]) +
                                                "; the mesh has only " + std::to_string(mesh.mNumVertices) +
                                                " vertices.");
  }
}

Surface to_surface(const aiMesh& mesh, const Transform& transform, std::uint32_t material) {
  Surface surface;
  const std::size_t count = mesh.mNumVertices;
  const bool identity = transform == Transform{};
  const bool mirrored = transform.determinant() < 0;
  surface.positions.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    surface.positions[v] = identity ? Vec3f{p.x, p.y, p.z} : to_float(transform.point({p.x, p.y, p.z}));
  }
  if (mesh.HasNormals()) {
    surface.attributes.normals.resize(count);
    for (std::size_t v = 0; v < count; ++v) {
      const Vec3d n{mesh.mNormals[v].x, mesh.mNormals[v].y, mesh.mNormals[v].z};
      surface.attributes.normals[v] = unit_float(identity ? n : transform.normal(n));
    }
  }
  for (unsigned set = 0; set < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.mTextureCoords[set] != nullptr; ++set) {
    auto& uvs = surface.attributes.uvs.emplace_back(count);
    // Assimp's v axis points up, and glTF's points down.
    for (std::size_t v = 0; v < count; ++v)
      uvs[v] = {mesh.mTextureCoords[set][v].x, 1.0f - mesh.mTextureCoords[set][v].y};
  }
  for (unsigned set = 0; set < AI_MAX_NUMBER_OF_COLOR_SETS && mesh.mColors[set] != nullptr; ++set) {
    auto& colors = surface.attributes.colors.emplace_back(count);
    for (std::size_t v = 0; v < count; ++v) {
      const aiColor4D& c = mesh.mColors[set][v];
      colors[v] = {c.r, c.g, c.b, c.a};
    }
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    const unsigned* i = face.mIndices;
    surface.triangles.push_back(mirrored ? std::array{i[0], i[2], i[1]} : std::array{i[0], i[1], i[2]});
  }
  surface.materials.assign(surface.triangles.size(), material);
  merge_identical_wedges(surface);
  return surface;
}

/// Names that Assimp invents for unnamed nodes do not come from the source.
std::string node_name(const aiNode& node) {
  const std::string name = name_as_utf8(node.mName.C_Str());
  return name.empty() || name == "defaultobject" || name[0] == '<' ? "mesh" : name;
}

/// The name of a node above others; empty if it does not come from the source. The root stands for the file.
std::string group_name(const aiNode& node) {
  const std::string name = name_as_utf8(node.mName.C_Str());
  return node.mParent == nullptr || name.starts_with('<') ? std::string() : name;
}

void add_dropped(const aiMesh& mesh, std::vector<Dropped>& dropped) {
  const std::string name = mesh.mName.C_Str();
  if (mesh.HasBones()) dropped.push_back({"bones", name, "their pose is applied; fragments have no bones"});
  if (mesh.mNumAnimMeshes > 0)
    dropped.push_back({"morph targets", name, "fragments do not morph; the base shape is used"});
  if ((mesh.mPrimitiveTypes & aiPrimitiveType_POINT) != 0)
    dropped.push_back({"points", name, "only triangles are fractured"});
  if ((mesh.mPrimitiveTypes & aiPrimitiveType_LINE) != 0)
    dropped.push_back({"lines", name, "only triangles are fractured"});
}

void add_dropped(const aiScene& scene, std::vector<Dropped>& dropped) {
  const auto add = [&](auto* const* entries, unsigned count, const char* what, const char* reason) {
    for (unsigned k = 0; k < count; ++k)
      if (entries[k] != nullptr) dropped.push_back({what, entries[k]->mName.C_Str(), reason});
  };
  add(scene.mAnimations, scene.mNumAnimations, "animation", "fragments are not animated");
  add(scene.mLights, scene.mNumLights, "light", "answers have no lights");
  add(scene.mCameras, scene.mNumCameras, "camera", "answers have no cameras");
}

Transform below(const Transform& parent, const aiNode& node) {
  const Transform local = to_transform(node.mTransformation);
  return parent == Transform{} ? local : local == Transform{} ? parent : parent * local;
}

Box box_of(const aiMesh& mesh) {
  Box box;
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) box.add(Vec3d{p.x, p.y, p.z});
  }
  return box;
}

/// The offset of the scene (file_positions.hpp), by the boxes of its meshes.
Vec3d offset_of(const aiScene& scene) {
  std::vector<Box> boxes;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) boxes.push_back(box_of(*scene.mMeshes[m]));
  Box all;
  std::vector<std::pair<const aiNode*, Transform>> stack{{scene.mRootNode, Transform{}}};
  while (!stack.empty()) {
    const auto [node, parent] = stack.back();
    stack.pop_back();
    const Transform world = below(parent, *node);
    for (unsigned k = 0; k < node->mNumMeshes; ++k) {
      if (node->mMeshes[k] >= boxes.size() || boxes[node->mMeshes[k]].empty()) continue;
      const Box& box = boxes[node->mMeshes[k]];
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p = world.point({(corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                                     (corner & 4 ? box.max : box.min).z});
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) all.add(p);
      }
    }
    for (unsigned k = 0; k < node->mNumChildren; ++k)
      if (node->mChildren[k] != nullptr) stack.emplace_back(node->mChildren[k], world);
  }
  return offset_for(all);
}

/// `offset`: subtracted from all positions before they are rounded.
void add_scene(const aiScene& scene, const std::vector<std::uint32_t>& slots, const Vec3d& offset,
               MeshBuilder& builder) {
  struct Waiting {
    const aiNode* node;
    Transform parent;
    std::uint32_t group;  ///< of the nodes above
    std::uint32_t above;  ///< number of the source's node above it in the tree
  };
  Transform root;
  root.t = root.t - offset;
  std::vector<Waiting> stack{{scene.mRootNode, root, kNoIndex, kNoIndex}};
  while (!stack.empty()) {
    const auto [node, parent, group_above, above] = stack.back();
    stack.pop_back();
    const Transform world = below(parent, *node);
    const std::uint32_t own =
        builder.add_source_node(node->mNumMeshes > 0 ? node_name(*node) : group_name(*node), above);
    if (node->mNumMeshes > 0) {
      builder.begin_node(node_name(*node), group_above);
      builder.set_source_node(own);
    }
    for (unsigned k = 0; k < node->mNumMeshes; ++k) {
      if (node->mMeshes[k] >= scene.mNumMeshes)
        refuse(ErrorCode::kMalformedMesh, "A node refers to a mesh that does not exist.");
      const aiMesh& mesh = *scene.mMeshes[node->mMeshes[k]];
      if (mesh.HasBones()) builder.remarks().note("Skins were baked in the bind pose.");
      add_dropped(mesh, builder.dropped());
      const std::uint32_t material =
          mesh.mMaterialIndex < slots.size() ? slots[mesh.mMaterialIndex] : kNoIndex;
      Surface surface = to_surface(mesh, world, material);
      if (surface.triangles.empty()) continue;
      if (auto added = builder.add(std::move(surface)); !added) throw Refused{added.error()};
    }
    const std::uint32_t group =
        node->mNumChildren > 0 ? builder.add_group(group_name(*node), group_above) : group_above;
    for (unsigned k = node->mNumChildren; k-- > 0;)  // the RAW reader leaves null children
      if (node->mChildren[k] != nullptr) stack.push_back({node->mChildren[k], world, group, own});
  }
}

/// FBX: the unit in centimetres, and the axis that is up as 0, 1 or 2 (GlobalSettings).
SourceFrame fbx_frame(const aiScene& scene, MeshBuilder& builder) {
  SourceFrame frame;
  if (scene.mMetaData == nullptr) return frame;
  float centimetres = 0;
  if (scene.mMetaData->Get("UnitScaleFactor", centimetres) && std::isfinite(centimetres) && centimetres > 0) {
    frame.metres = static_cast<double>(centimetres) / 100;
    frame.metres_stated = true;
  }
  std::int32_t up = 1, sign = 1;
  if (scene.mMetaData->Get("UpAxis", up)) {
    scene.mMetaData->Get("UpAxisSign", sign);
    frame.z_up = up == 2;
    frame.up_stated = (up == 1 || up == 2) && sign == 1;
    if (!frame.up_stated)
      builder.remarks().warn(
          "The file's up axis is neither y nor z, so " + std::string(frame.z_up ? "z" : "y") +
          " was assumed. The fragments may lie on their side. If so, export the mesh with y or z up, "
          "or set 'up'.");
  }
  return frame;
}

}  // namespace

Expected<Mesh> import_with_assimp(std::span<const std::byte> bytes, MeshFormat format,
                                  const ImportLimits& limits, std::span<const ImportFile> files) {
  try {
    const std::string name = main_name(format, files);
    Assimp::Importer importer;
    keep_only(importer, format == MeshFormat::kXml ? "mesh.xml" : extension_of(format));
    importer.SetIOHandler(new UploadedFiles(name, bytes, files));  // owned by the importer
    importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
    const auto check = [&importer, format](const aiScene* read) {
      if (read != nullptr && read->mRootNode != nullptr) return;
      std::string reason = importer.GetErrorString();
      if (reason == "std::bad_alloc") throw std::bad_alloc();  // Assimp catches all exceptions
      for (char& c : reason) c = c >= 0x20 && c < 0x7f ? c : ' ';
      refuse(ErrorCode::kMalformedMesh,
             "The file cannot be read as " + std::string(extension_of(format)) + ": " +
                 (reason.empty() ? "its reader gives no reason." : reason.substr(0, 300)) +
                 (reason.empty() || reason.ends_with('.') ? "" : ".") +
                 " Export it again, preferably as GLB.");
    };
    const aiScene* scene = importer.ReadFile(name, 0);
    check(scene);
    check_indices(*scene);
    fan_polygons(const_cast<aiScene&>(*scene));  // owned by the importer, which permits changes
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    check(scene);

    MeshBuilder builder(limits);
    TranslatedMaterials materials = translate_materials(*scene, files);
    builder.remarks().add(materials.remarks);
    builder.dropped() = std::move(materials.dropped);
    builder.set_library(std::move(materials.library));
    add_dropped(*scene, builder.dropped());
    const Vec3d offset = offset_of(*scene);
    add_scene(*scene, materials.slot, offset, builder);
    SourceFrame frame = format == MeshFormat::kFbx ? fbx_frame(*scene, builder) : SourceFrame{};
    frame.offset = offset;
    Expected<Mesh> mesh = builder.finish();
    if (mesh) mesh->frame = frame;
    return mesh;
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
