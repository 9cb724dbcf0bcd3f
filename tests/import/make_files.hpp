// Small mesh files made by hand, so that each test shows their content.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/import/import.hpp"

namespace fracture::test {

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

/// Appends numbers as little-endian bytes.
template <class T>
void put(std::string& out, std::initializer_list<T> values) {
  for (const T value : values) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    out.append(raw, sizeof(T));
  }
}

inline std::string make_glb(const nlohmann::json& document, std::string binary) {
  std::string json = document.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string glb;
  const std::uint32_t total =
      static_cast<std::uint32_t>(12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size()));
  put<std::uint32_t>(glb, {0x46546c67u, 2u, total, static_cast<std::uint32_t>(json.size()), 0x4e4f534au});
  glb += json;
  if (!binary.empty()) {
    put<std::uint32_t>(glb, {static_cast<std::uint32_t>(binary.size()), 0x004e4942u});
    glb += binary;
  }
  return glb;
}

/// The tetrahedron (0,0,0) (1,0,0) (0,1,0) (0,0,1), facing outwards, with volume 1/6. Accessor 0 has the
/// positions and accessor 1 the indices (unsigned short). The file has one node and one scene.
struct Tetrahedron {
  nlohmann::json json;
  std::string binary;

  Tetrahedron() {
    put<float>(binary, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
    put<std::uint16_t>(binary, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
    json = {{"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"scenes", {{{"nodes", {0}}}}},
            {"nodes", {{{"mesh", 0}, {"name", "tet"}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
            {"accessors",
             {{{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
              {{"bufferView", 1}, {"componentType", 5123}, {"count", 12}, {"type", "SCALAR"}}}},
            {"bufferViews",
             {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 48}},
              {{"buffer", 0}, {"byteOffset", 48}, {"byteLength", 24}}}},
            {"buffers", {{{"byteLength", 72}}}}};
  }
  std::string glb() const { return make_glb(json, binary); }
  /// Adds the bytes as a new bufferView with an accessor over all of it. Returns the accessor.
  std::size_t add_accessor(const std::string& bytes, int component, std::size_t count, const char* type,
                           bool normalized = false) {
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary += bytes;
    json["buffers"][0]["byteLength"] = binary.size();
    nlohmann::json accessor = {{"bufferView", json["bufferViews"].size() - 1},
                               {"componentType", component},
                               {"count", count},
                               {"type", type}};
    if (normalized) accessor["normalized"] = true;
    json["accessors"].push_back(accessor);
    return json["accessors"].size() - 1;
  }
  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }
  nlohmann::json& node() { return json["nodes"][0]; }
};

/// The signed volume, by the divergence theorem.
inline double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += dot(to_double(mesh.positions[t[0]]),
               cross(to_double(mesh.positions[t[1]]), to_double(mesh.positions[t[2]])));
  return sum / 6;
}

inline Expected<Mesh> import_text(std::string_view bytes, MeshFormat format, const ImportLimits& limits = {},
                                  std::span<const ImportFile> files = {}) {
  return import_mesh(bytes_of(bytes), format, limits, files);
}

}  // namespace fracture::test
