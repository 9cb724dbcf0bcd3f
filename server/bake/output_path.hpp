// Where a bake may write to, and which of two paths are the same file.
#pragma once

#include <sys/types.h>

#include <compare>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "server/service/engine.hpp"

namespace fracture::bake {

/// As an input: standard input. As an output: standard output.
inline constexpr const char* kStandardStream = "-";

/// How an output is written: the first two are answers as they are, the others are made of one.
enum class OutputKind { kGlb, kGltf, kObj, kPly, kStl };

/// By the ending, in any case: .glb or none is GLB, .gltf one JSON text, .obj, .ply and .stl. kBadParameter for any other,
/// with those that there are in extra.known, and where an OBJ could not name its materials.
Expected<OutputKind> kind_of_output(const std::string& path);
/// What is asked of the engine or of a server for it.
OutputFormat answer_format(OutputKind kind);
/// The file of an OBJ's materials: x.mtl for x.obj. Empty for all other outputs.
std::string materials_beside(const std::string& path);

/// kBadParameter where no file may be written: a folder, a device, a pipe, a socket or an open descriptor lies there.
/// Nothing: a file or nothing does. What cannot be looked at is left to whoever writes it.
std::optional<Error> refuse_output(const std::string& path);

/// What a path leads to, however it is spelt: by device and inode, so that links are what they lead to, hard
/// links are one file, and upper and lower case are the same where the file system says so.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  std::string below;  ///< of what is not there yet: its path below the nearest folder that is
  auto operator<=>(const FileIdentity&) const = default;
};
FileIdentity identity_of(const std::string& path);

}  // namespace fracture::bake
