#include "server/bake/output_path.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "common/import/formats.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

/// Returns whether the path, or a symbolic link on its way, leads to an open file descriptor of a process
/// (/dev/stdout, /dev/fd/1, /proc/self/fd/1). Renaming a file to such a path would replace the link, not the
/// file behind it.
bool is_open_descriptor(fs::path path) {
  constexpr int kMostLinks = 40;  // the kernel's own limit
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code error;
    const fs::path folder = fs::canonical(path.has_parent_path() ? path.parent_path() : ".", error);
    if (error) return false;
    path = folder / path.filename();
    if (folder.string().starts_with("/proc/")) return true;
    const fs::path target = fs::read_symlink(path, error);
    if (error) return false;
    path = folder / target;
  }
  return false;
}

}  // namespace

Expected<OutputKind> kind_of_output(const std::string& path) {
  const std::string ending = fs::path(path).extension().string();
  const std::optional<MeshFormat> format =
      ending.empty() ? MeshFormat::kGlb : format_from_extension(ending.substr(1));
  if (format == MeshFormat::kGlb) return OutputKind::kGlb;
  if (format == MeshFormat::kGltf) return OutputKind::kGltf;
  if (format == MeshFormat::kPly) return OutputKind::kPly;
  if (format == MeshFormat::kStl) return OutputKind::kStl;
  if (format != MeshFormat::kObj)
    return fail(ErrorCode::kBadParameter,
                "'" + ending + "' cannot be written: the output '" + path +
                    "' must end in .glb, .gltf (a single JSON document), .obj (with .mtl and textures), "
                    ".ply or .stl, or have no extension (which means GLB).",
                {}, {{"known", {".glb", ".gltf", ".obj", ".ply", ".stl"}}});
  const std::string name = fs::path(path).filename().string();
  const bool breaks = std::any_of(name.begin(), name.end(),
                                  [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; });
  if (breaks || name.front() == ' ' || name.front() == '-')
    return fail(
        ErrorCode::kBadParameter,
        "The OBJ file '" + path +
            "' could not reference its .mtl file: its name must not begin with a space or '-', and must not "
            "contain control characters.");
  return OutputKind::kObj;
}

OutputFormat answer_format(OutputKind kind) {
  return kind == OutputKind::kGltf ? OutputFormat::kGltf : OutputFormat::kGlb;
}

std::string materials_beside(const std::string& path) {
  const Expected<OutputKind> kind = kind_of_output(path);
  return kind && *kind == OutputKind::kObj ? fs::path(path).replace_extension(".mtl").string()
                                           : std::string();
}

std::optional<Error> refuse_output(const std::string& path) {
  const auto refused = [&](const char* why) {
    return Error{ErrorCode::kBadParameter, "'" + path + "' " + why + "."};
  };
  if (path.ends_with('/')) return refused("names a folder, not a file");
  if (is_open_descriptor(path))
    return refused("is an open file descriptor of a process; for standard output, give '-'");
  struct stat there {};
  if (::stat(path.c_str(), &there) != 0 || S_ISREG(there.st_mode)) return std::nullopt;
  if (S_ISDIR(there.st_mode)) return refused("is a folder");
  if (S_ISFIFO(there.st_mode)) return refused("is a pipe; for standard output, give '-'");
  if (S_ISSOCK(there.st_mode)) return refused("is a socket");
  return refused("is a device; for standard output, give '-'");
}

FileIdentity identity_of(const std::string& path) {
  std::error_code error;
  fs::path there = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) return {.below = fs::path(path).lexically_normal().string()};
  struct stat found {};
  fs::path below;
  while (::stat(there.c_str(), &found) != 0) {
    if (!there.has_relative_path()) return {.below = there.string() + below.string()};
    below = below.empty() ? there.filename() : there.filename() / below;
    there = there.parent_path();
  }
  return {found.st_dev, found.st_ino, below.string()};
}

}  // namespace fracture::bake
