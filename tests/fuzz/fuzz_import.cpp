// Fuzz target: the first byte chooses the format, the rest is the file. For every input import_mesh returns a
// valid Mesh or an Error with a sentence. It does not crash, hang or allocate memory that the file merely
// declares. Formats that run only in the sandbox (BLEND, FBX, DAE, 3DS) and the inside of Assimp are not the
// target here. OBJ has a target of its own (fuzz_obj).
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/import/import.hpp"
#include "common/import/preflight.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  if (size < 1) return 0;
  const std::span<const std::byte> file{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  ImportLimits limits;
  limits.max_triangles = 10'000;
  limits.max_decoded_bytes = 16u << 20;
  switch (data[0] % 5) {
    case 0:
    case 1: {
      const auto mesh = import_mesh(file, data[0] % 5 == 0 ? MeshFormat::kGlb : MeshFormat::kGltf, limits);
      if (!mesh && mesh.error().detail.empty()) std::abort();
      if (mesh)
        for (const auto& triangle : mesh->triangles)
          for (const std::uint32_t wedge : triangle)
            if (wedge >= mesh->positions.size()) std::abort();
      break;
    }
    case 2:
      (void)preflight::check_stl(file, limits);
      break;
    case 3:
      (void)preflight::check_ply(file, limits);
      break;
    default:
      (void)preflight::check_off(file, limits);
      break;
  }
  return 0;
}
