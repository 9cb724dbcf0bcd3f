// The mesh formats there are, from one table (formats.def): what a file of each is called, how it is told
// from others, and what its coordinates mean. tinygltf reads glTF; all others are Assimp's.
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

/// What a format says about axes and units where its files do not.
enum class FormatFrame { kUnknown, kYUp, kZUp, kMetresYUp };

/// Which library reads a format. import.cpp calls each.
enum class FormatReader { kTinygltf, kAssimp };

struct FormatInfo {
  MeshFormat format;
  const char* name;              ///< its value as a parameter, and its first extension
  std::string_view extensions;   ///< others, separated by blanks
  std::string_view media_types;  ///< separated by blanks
  std::string_view magic;        ///< first bytes of most of its files; empty: nothing is typical
  FormatEncoding encoding;
  FormatFrame frame;
  FormatReader reader;
  /// glTF, GLB, OBJ, STL, PLY and OFF; the others run larger or older parsers and are off by default.
  bool enabled_by_default;
  const char* without_surface;  ///< what its files hold where that is no surface; empty for meshes
};

/// In the order of the enum.
std::span<const FormatInfo> all_formats();
const FormatInfo& format_info(MeshFormat format);

/// From a file extension without the dot ("glb", "OBJ") or a media type ("model/gltf-binary").
std::optional<MeshFormat> format_from_extension(std::string_view extension);
std::optional<MeshFormat> format_from_media_type(std::string_view media_type);
/// From what the file begins with, for files whose name says nothing; formats without a typical beginning are
/// not found.
std::optional<MeshFormat> format_from_content(std::span<const std::byte> bytes);

inline const char* extension_of(MeshFormat format) { return format_info(format).name; }
inline bool enabled_by_default(MeshFormat format) { return format_info(format).enabled_by_default; }

}  // namespace fracture
