// Fuzz target: a 3MF package if the first byte is even, otherwise the text of a model part, which a checksum protects inside a
// package. Every input gives a valid Mesh or an Error with a sentence.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "common/import/refused.hpp"
#include "common/import/threemf_import.hpp"
#include "common/import/threemf_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  if (size < 1) return 0;
  const std::span<const std::byte> file{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  if (data[0] % 2 == 0) {
    ImportLimits limits;
    limits.max_triangles = 10'000;
    limits.max_decoded_bytes = 1u << 20;
    const auto mesh = import_3mf(file, limits);
    if (!mesh && mesh.error().detail.empty()) std::abort();
    if (mesh)
      for (const auto& triangle : mesh->triangles)
        for (const std::uint32_t wedge : triangle)
          if (wedge >= mesh->positions.size()) std::abort();
    return 0;
  }
  try {
    const threemf::ModelPart part =
        threemf::read_model_part({reinterpret_cast<const char*>(file.data()), file.size()}, "part");
    for (const auto& [id, object] : part.objects)
      if (object.materials.size() != object.triangles.size()) std::abort();
  } catch (const Refused& refused) {
    if (refused.error.detail.empty()) std::abort();
  }
  return 0;
}
