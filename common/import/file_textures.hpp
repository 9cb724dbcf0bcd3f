// Adds the images that a mesh file refers to by name to its material library.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {

class FileTextures {
 public:
  /// The textures and images are added to `library`, which must live as long as this object, like `files`, `remarks` and
  /// `dropped`.
  FileTextures(std::span<const ImportFile> files, MaterialLibrary& library, Remarks& remarks,
               std::vector<Dropped>& dropped)
      : files_(files), library_(library), remarks_(remarks), dropped_(dropped) {}

  /// Returns the index of the glTF texture with this image. If it is missing or neither PNG nor JPEG, it is added to `dropped`, with
  /// a warning, and the result is kNoIndex.
  /// `embedded`: the image's bytes; empty: they are in the file `path` of the upload. Each path is added only once.
  std::uint32_t texture(const std::string& path, std::span<const std::uint8_t> embedded = {});

 private:
  std::span<const ImportFile> files_;
  MaterialLibrary& library_;
  Remarks& remarks_;
  std::vector<Dropped>& dropped_;
  std::map<std::string, std::uint32_t> known_;
};

}  // namespace fracture
