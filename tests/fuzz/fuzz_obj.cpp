// Fuzz target: an OBJ file up to the first zero byte, and the material library "a.mtl" after it. For every input import_mesh
// returns a mesh whose indices are valid and whose positions are finite, or an error with a sentence. The text in both is
// UTF-8. It does not crash or hang.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "common/import/import.hpp"
#include "common/import/sibling_files.hpp"
#include "common/import/text_encoding.hpp"
#include "common/mesh/material_library.hpp"

namespace {

void require(bool kept) {
  if (!kept) std::abort();
}

void judge(const fracture::Mesh& mesh) {
  using namespace fracture;
  require(mesh.material.size() == mesh.triangles.size() && mesh.node.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t wedge : mesh.triangles[t]) require(wedge < mesh.positions.size());
    require(mesh.material[t] == kNoIndex || mesh.material[t] < mesh.library->materials.size());
    require(mesh.node[t] < mesh.node_names.size());
  }
  for (const Vec3f& p : mesh.positions)
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (int axis = 0; axis < 3; ++axis) {
    const double offset = mesh.frame.offset[axis];
    require(offset == static_cast<double>(static_cast<float>(offset)));
  }
  for (const auto* list : {&mesh.node_names, &mesh.remarks.warnings, &mesh.remarks.notes})
    for (const std::string& text : *list) require(is_utf8(text));
  for (const Dropped& dropped : mesh.dropped) require(is_utf8(dropped.name));
  (void)mesh.library->materials.dump();  // throws if a name is not UTF-8
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  const std::span<const std::byte> input{reinterpret_cast<const std::byte*>(data), size};
  const std::size_t zero = static_cast<std::size_t>(std::find(data, data + size, std::uint8_t{0}) - data);
  const std::span<const std::byte> obj = input.first(zero), mtl = input.subspan(std::min(size, zero + 1));
  ImportLimits limits;
  limits.max_triangles = 10'000;
  limits.max_decoded_bytes = 16u << 20;
  (void)referenced_files(obj, MeshFormat::kObj);
  (void)textures_of_mtl({reinterpret_cast<const char*>(mtl.data()), mtl.size()});
  const ImportFile file{"a.mtl", mtl};
  const auto mesh = import_mesh(obj, MeshFormat::kObj, limits, {&file, 1});
  if (mesh)
    judge(*mesh);
  else
    require(!mesh.error().detail.empty() && is_utf8(mesh.error().detail));
  return 0;
}
