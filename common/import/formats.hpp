// All mesh formats, from one table (formats.def): their names, how to recognize their files, and the meaning
// of their coordinates. tinygltf reads glTF, our own readers read OBJ, STL, PLY, OFF and 3MF, and Assimp reads the others.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace fracture {

enum class MeshFormat {
#define FRACTURE_MESH_FORMAT(enumerator, name, extensions, media, magic, encoding, frame, reader, on, none) \
  enumerator,
#include "common/import/formats.def"
#undef FRACTURE_MESH_FORMAT
};

enum class FormatEncoding { kBinary, kText, kXml };

/// Axes and units that a format defines if its files do not state them.
enum class FormatFrame { kUnknown, kYUp, kZUp, kMetresYUp };

/// The library that reads a format; kOwn: a reader in this folder. import.cpp calls each.
enum class FormatReader { kTinygltf, kOwn, kAssimp };

struct FormatInfo {
  MeshFormat format;
  const char* name;              ///< value of the parameter `format`, and the first file extension
  std::string_view extensions;   ///< other extensions, separated by blanks
  std::string_view media_types;  ///< separated by blanks
  std::string_view magic;        ///< first bytes of most files; empty if nothing is typical
  FormatEncoding encoding;
  FormatFrame frame;
  FormatReader reader;
  /// True for glTF, GLB, OBJ, STL, PLY and OFF. The others run larger or older parsers and are off by
  /// default.
  bool enabled_by_default;
  const char* without_surface;  ///< what the files contain instead of a surface; empty for meshes
};

/// All formats, in the order of the enum.
std::span<const FormatInfo> all_formats();
const FormatInfo& format_info(MeshFormat format);

/// Finds a format by file extension without the dot ("glb", "OBJ") or by media type ("model/gltf-binary").
std::optional<MeshFormat> format_from_extension(std::string_view extension);
std::optional<MeshFormat> format_from_media_type(std::string_view media_type);
/// Finds a format by the first bytes, for files with an uninformative name. Formats without typical first
/// bytes are not found.
std::optional<MeshFormat> format_from_content(std::span<const std::byte> bytes);

inline const char* extension_of(MeshFormat format) { return format_info(format).name; }
inline bool enabled_by_default(MeshFormat format) { return format_info(format).enabled_by_default; }

}  // namespace fracture
