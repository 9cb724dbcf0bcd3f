// The only files that Assimp can see: the uploaded file under one name, and the additional files of the upload.
#pragma once

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <cstddef>
#include <span>
#include <string>

#include "common/import/import_input.hpp"

namespace fracture {

/// A file system that contains only the upload. The upload does not say what the main file was called, so it
/// is named "mesh". Some readers look for companion files under a name derived from it ("mesh_d.3d" next to
/// "mesh_a.3d", "mesh.skin"). These are found by the rest of the name after "mesh", if exactly one further
/// file ends with it.
class UploadedFiles : public Assimp::IOSystem {
 public:
  UploadedFiles(std::string main_name, std::span<const std::byte> main, std::span<const ImportFile> files)
      : main_name_(std::move(main_name)), main_(main), files_(files) {}

  bool Exists(const char* name) const override { return find(name) != nullptr; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::span<const std::byte>* find(std::string_view name) const;

  std::string main_name_;
  std::span<const std::byte> main_;
  std::span<const ImportFile> files_;
};

}  // namespace fracture
