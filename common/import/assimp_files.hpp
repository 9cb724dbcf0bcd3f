// The only files Assimp can see: the upload's own bytes under one name, and its further parts.
#pragma once

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <cstddef>
#include <span>
#include <string>

#include "common/import/import_input.hpp"

namespace fracture {

/// Companions that a reader looks for under a name made from the main file's ("mesh_d.3d" beside "mesh_a.3d",
/// "mesh.skin") are found by what follows "mesh" where exactly one further part ends so: the upload does not
/// say what the main file was called.
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
