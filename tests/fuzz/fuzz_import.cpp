// Fuzz target: the first byte chooses the format, the rest is the file. For every input import_mesh returns a
// valid Mesh or an Error with a sentence. It does not crash, hang or allocate memory that the file merely
// declares. Formats that run only in the sandbox (BLEND, FBX, DAE, 3DS) and the inside of Assimp are not the
// target here. OBJ, STL, PLY and OFF also have their own targets, with a corpus for each.
#include <cstddef>
#include <cstdint>
#include <span>

#include "tests/fuzz/check_import.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  if (size < 1) return 0;
  const std::span<const std::byte> file{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  ImportLimits limits;
  limits.max_triangles = 10'000;
  limits.max_decoded_bytes = 16u << 20;
  constexpr MeshFormat kFormats[] = {MeshFormat::kGlb, MeshFormat::kGltf, MeshFormat::kStl,
                                     MeshFormat::kPly, MeshFormat::kOff,  MeshFormat::kObj};
  test::check_import(file, kFormats[data[0] % 6], limits);
  return 0;
}
