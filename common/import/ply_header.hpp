// The header of a PLY file: its elements and their properties.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

/// Bytes of a value in a binary file.
std::size_t ply_bytes(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  std::optional<PlyType> length;  ///< of a list: the type of its length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  ///< names in "comment TextureFile" (MeshLab)
  std::size_t end = 0;                ///< first byte of the data
};

/// Reads the header (Turk 1994, "The PLY polygon file format"). Lines end as the first one does: LF, CRLF or CR. So the data of a
/// binary file may begin with any byte. Comments and obj_info are skipped, like lines that begin with an unknown word.
/// Checks that the declared elements fit into the rest of the file. Throws Refused (kMalformedMesh, with the line).
PlyHeader read_ply_header(std::string_view file);

}  // namespace fracture
