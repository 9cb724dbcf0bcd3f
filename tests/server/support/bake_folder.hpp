// A folder of meshes for bakes, and the outputs of a bake.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {

namespace fs = std::filesystem;

/// A unit cube whose positions and indices are in "box data/box.bin".
inline void write_gltf_box(const TemporaryFolder& folder) {
  std::string buffer;
  const auto put = [&](const auto value) {
    buffer.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) put(static_cast<float>(corner >> axis & 1));
  for (const int corner : {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                           2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5})
    put(static_cast<std::uint16_t>(corner));
  fs::create_directories(folder / "in/gltf/box data");
  folder.write("in/gltf/box data/box.bin", buffer);
  folder.write("in/gltf/box.gltf", R"({"asset": {"version": "2.0"},
    "buffers": [{"uri": "box%20data/box.bin", "byteLength": 168}],
    "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 1]},
                  {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0})");
}

/// Boxes with different sides, the last one as a glTF with its own buffer, and a mesh that cannot be
/// fractured.
inline void write_meshes(const TemporaryFolder& folder, int count) {
  fs::create_directories(folder / "in/poison");
  write_gltf_box(folder);
  for (int k = 0; k < count - 1; ++k) {
    const std::string x = std::to_string(1 + k);
    folder.write("in/box" + x + ".obj",
                 "v 0 0 0\nv " + x + " 0 0\nv " + x + " 1 0\nv 0 1 0\nv 0 0 1\nv " + x + " 0 1\nv " + x +
                     " 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  }
  folder.write("in/poison/sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
}

/// All files except reports, by their paths inside the folder.
inline std::map<std::string, std::string> outputs(const std::string& folder) {
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".ndjson") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files[entry.path().lexically_relative(folder).string()] = {std::istreambuf_iterator<char>(file), {}};
  }
  return files;
}

inline std::size_t lines_in(const std::string& path) {
  std::ifstream file(path);
  std::size_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  return lines;
}

}  // namespace fracture::test
