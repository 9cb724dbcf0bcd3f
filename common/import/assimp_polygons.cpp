#include "common/import/assimp_polygons.hpp"

#include <utility>
#include <vector>

#include "common/base/vec.hpp"
#include "common/import/polygon_triangles.hpp"

namespace fracture {
namespace {

void fan_polygons(aiMesh& mesh) {
  if (!(mesh.mPrimitiveTypes & aiPrimitiveType_POLYGON)) return;
  std::vector<bool> fan(mesh.mNumFaces, false);
  unsigned count = 0;
  std::vector<Vec3d> corners;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices > 3) {
      corners.clear();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const aiVector3D& p = mesh.mVertices[face.mIndices[k]];
        corners.push_back({p.x, p.y, p.z});
      }
      fan[f] = !flat_with_reflex_corner(corners);
    }
    count += fan[f] ? face.mNumIndices - 2 : 1;
  }

  auto* faces = new aiFace[count];
  unsigned n = 0;
  bool polygons = false;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    aiFace& face = mesh.mFaces[f];
    if (!fan[f]) {
      polygons |= face.mNumIndices > 3;
      faces[n].mNumIndices = std::exchange(face.mNumIndices, 0u);
      faces[n++].mIndices = std::exchange(face.mIndices, nullptr);
      continue;
    }
    for (unsigned k = 1; k + 1 < face.mNumIndices; ++k) {
      faces[n].mNumIndices = 3;
      faces[n++].mIndices = new unsigned[3]{face.mIndices[0], face.mIndices[k], face.mIndices[k + 1]};
    }
  }
  delete[] mesh.mFaces;
  mesh.mFaces = faces;
  mesh.mNumFaces = n;
  // The flags must be correct, because aiProcess_Triangulate aborts on a mesh that announces polygons but has
  // none.
  mesh.mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
  if (!polygons) mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
}

}  // namespace

void fan_polygons(aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) fan_polygons(*scene.mMeshes[m]);
}

}  // namespace fracture
