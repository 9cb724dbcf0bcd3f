#include "common/import/assimp_quads.hpp"

#include <array>
#include <utility>

#include "common/base/vec.hpp"

namespace fracture {
namespace {

Vec3d at(const aiMesh& mesh, unsigned index) {
  const aiVector3D& p = mesh.mVertices[index];
  return {p.x, p.y, p.z};
}

/// Does the fan (a, b, c), (a, c, d) fold flat over itself, as that of a planar quad with a reflex corner at
/// b or d does? A bent quad does not: its two triangles meet at an angle.
bool folds(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d n = cross(b - a, c - a), m = cross(c - a, d - a);
  return dot(n, m) < -0.9 * length(n) * length(m);
}

void set_triangle(aiFace& face, const std::array<unsigned, 3>& corners) {
  delete[] face.mIndices;
  face.mNumIndices = 3;
  face.mIndices = new unsigned[3]{corners[0], corners[1], corners[2]};
}

void fan_quads(aiMesh& mesh) {
  unsigned quads = 0, larger = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    quads += mesh.mFaces[f].mNumIndices == 4;
    larger += mesh.mFaces[f].mNumIndices > 4;
  }
  if (quads == 0) return;
  auto* faces = new aiFace[mesh.mNumFaces + quads];
  unsigned n = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 4) {
      faces[n].mNumIndices = std::exchange(face.mNumIndices, 0u);
      faces[n++].mIndices = std::exchange(face.mIndices, nullptr);
      continue;
    }
    const unsigned* i = face.mIndices;
    const Vec3d a = at(mesh, i[0]), b = at(mesh, i[1]), c = at(mesh, i[2]), d = at(mesh, i[3]);
    const unsigned s = folds(a, b, c, d) && !folds(b, c, d, a) ? 1 : 0;  // the corner the fan starts from
    set_triangle(faces[n++], {i[s], i[s + 1], i[s + 2]});
    set_triangle(faces[n++], {i[s], i[s + 2], i[(s + 3) % 4]});
  }
  delete[] mesh.mFaces;
  mesh.mFaces = faces;
  mesh.mNumFaces = n;
  // The flags must tell the truth: aiProcess_Triangulate aborts on a mesh that announces polygons and has
  // none.
  bool polygons = false;
  for (unsigned f = 0; f < n; ++f) polygons |= mesh.mFaces[f].mNumIndices > 3;
  mesh.mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
  if (!polygons) mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
  // aiProcess_Triangulate aborts the process when it is told of polygons and finds none.
  mesh.mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
  if (larger == 0) mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
}

}  // namespace

void fan_quads(aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) fan_quads(*scene.mMeshes[m]);
}

}  // namespace fracture
