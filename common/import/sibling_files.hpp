// Finds files on disk that an asset refers to, for programs whose user owns the files (`bake`, `inspect`,
// tests). The server does not use this: its additional files are parts of the upload.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/import/import_input.hpp"

namespace fracture {

/// Returns the other files that a mesh file refers to, in order and without duplicates: buffers and images of
/// glTF and GLB, material files of OBJ, textures of PLY, FBX and DAE. Percent escapes are decoded, and backslashes
/// replaced. Data uris and urls with a scheme are not files. For other formats and for files that cannot be
/// parsed, the list is empty.
std::vector<std::string> referenced_files(std::span<const std::byte> bytes, MeshFormat format);
/// The textures that an OBJ's material library (.mtl) refers to.
std::vector<std::string> textures_of_mtl(std::string_view text);

struct SiblingFile {
  std::string name;  ///< as the asset refers to it
  std::string bytes;
  std::string path;  ///< its location
};

/// Reads the files that the asset at `path` and its material libraries refer to, from the asset's folder and
/// its subfolders. If a name is absolute, contains "..", or leads out of the folder through a link, only its
/// last component is used, as the importers do for textures. Missing files are left out; the importer reports
/// them.
/// STL and OFF refer to no files. For other formats that referenced_files() does not support, searches the folder and two levels of subfolders (at
/// most 1,000 entries). Reads files whose names occur in the bytes of the asset or of a file found this way,
/// and files that belong to the asset by name ("x_a.3d" to "x_d.3d", "x.skin" to "x.md3").
std::vector<SiblingFile> read_sibling_files(const std::string& path, std::span<const std::byte> bytes,
                                            MeshFormat format);

/// Returns views for import_mesh; valid as long as the files exist.
std::vector<ImportFile> as_import_files(const std::vector<SiblingFile>& files);

}  // namespace fracture
