// The mesh file of a command, with the files it names beside itself.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/import/sibling_files.hpp"
#include "server/parameters/parameters.hpp"

namespace fracture::bake {

struct InputFile {
  std::string bytes;
  std::vector<SiblingFile> siblings;
  std::span<const std::byte> view() const { return std::as_bytes(std::span(bytes)); }
};

/// As the parameters say, else by the name's ending; kUnknownFormat.
Expected<MeshFormat> format_of_input(const std::string& path, const RequestParameters& parameters);
/// False with errno set: asked first, a file that is not there is not one of an unknown format.
bool is_readable(const std::string& path);
/// Nothing when the file cannot be read; errno says why.
std::optional<InputFile> read_input(const std::string& path, MeshFormat format);

}  // namespace fracture::bake
