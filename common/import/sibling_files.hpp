// The files that an asset on a disk names: for programs whose user owns the file (`bake`, `inspect`, tests).
// The server never comes here: its further files are the parts of the upload.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/import/import_input.hpp"

namespace fracture {

/// The other files that a mesh file names, in the order it names them, each once, percent escapes decoded and
/// backslashes turned: buffers and images of glTF and GLB, material files of OBJ, textures of FBX and DAE.
/// Data uris and urls with a scheme are no files. A file that cannot be parsed names nothing, and neither do
/// the other formats.
std::vector<std::string> referenced_files(std::span<const std::byte> bytes, MeshFormat format);
/// The textures that a material library (.mtl) of an OBJ names.
std::vector<std::string> textures_of_mtl(std::string_view text);

struct SiblingFile {
  std::string name;  ///< as the asset names it
  std::string bytes;
  std::string path;  ///< where it lies
};

/// Reads what the asset at `path` names, and what its material libraries name, from its folder and below: a
/// name that is absolute, climbs with "..", or leads out of the folder through a link is looked up by its
/// last component alone, as the importers do for textures; what is not there is left out, for the importer to
/// report. For the formats that referenced_files() does not know: the files of the folder and two levels
/// below (1,000 entries at most) whose name occurs in the asset's bytes or in those of a file found so, and
/// those that belong to it by their name ("x_a.3d" to "x_d.3d", "x.skin" to "x.md3").
std::vector<SiblingFile> read_sibling_files(const std::string& path, std::span<const std::byte> bytes,
                                            MeshFormat format);

/// Views for import_mesh; valid as long as the files are.
std::vector<ImportFile> as_import_files(const std::vector<SiblingFile>& files);

}  // namespace fracture
