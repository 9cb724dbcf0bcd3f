// Checks where a bake may write, and whether two paths are the same file.
#pragma once

#include <sys/types.h>

#include <compare>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "server/service/engine.hpp"

namespace fracture::bake {

/// Standard input when used as an input, standard output when used as an output.
inline constexpr const char* kStandardStream = "-";

/// Format of an output file. The first two are the answer's own bytes; the others are converted from an
/// answer.
enum class OutputKind { kGlb, kGltf, kObj, kPly, kStl };

/// Returns the kind for the path's extension, ignoring case: .glb or no extension is GLB, .gltf is a single
/// JSON document; also .obj, .ply and .stl. Returns kBadParameter for other extensions, with the supported
/// ones in extra.known, and for an OBJ path whose name cannot be written in an `mtllib` line.
Expected<OutputKind> kind_of_output(const std::string& path);
/// Returns the format that is requested from the engine or server for an output of this kind.
OutputFormat answer_format(OutputKind kind);
/// Returns the path of an OBJ's material file: x.mtl for x.obj. Empty for all other outputs.
std::string materials_beside(const std::string& path);

/// Returns kBadParameter if the path is a folder, a device, a pipe, a socket or an open descriptor; nothing
/// if it is a regular file or does not exist. If the path cannot be inspected, also returns nothing: writing
/// then reports the error.
std::optional<Error> refuse_output(const std::string& path);

/// Identifies the file that a path leads to, however the path is spelt. Comparison is by device and inode, so
/// symbolic links equal their targets, hard links are one file, and case matters only if the file system
/// distinguishes it.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  std::string below;  ///< for a missing file: its path below the nearest existing folder
  auto operator<=>(const FileIdentity&) const = default;
};
FileIdentity identity_of(const std::string& path);

}  // namespace fracture::bake
