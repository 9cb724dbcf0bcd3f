// Fuzz target: the bytes are a worker's reply. The server accepts them as a valid Mesh or as a typed error
// with a sentence, or it refuses them. An accepted reply encodes to a reply that is accepted again, a mesh
// bit for bit.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "server/import_worker/mesh_codec.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  ImportLimits limits;
  limits.max_triangles = 100;
  try {
    const Expected<Mesh> mesh = decode_reply({reinterpret_cast<const std::byte*>(data), size}, limits);
    if (!mesh && mesh.error().detail.empty()) std::abort();
    if (mesh)
      for (const auto& triangle : mesh->triangles)
        for (const std::uint32_t wedge : triangle)
          if (wedge >= mesh->positions.size()) std::abort();
    const std::vector<std::byte> again = encode_reply(mesh);
    try {
      const Expected<Mesh> back = decode_reply(again, limits);  // the text of an error may be shortened
      if (back.has_value() != mesh.has_value() || (back && encode_reply(back) != again)) std::abort();
    } catch (const BadReply&) {
      std::abort();
    }
  } catch (const BadReply&) {
  }
  return 0;
}
