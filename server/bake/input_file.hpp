// The mesh file given to a command, with the files that it refers to.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/import/sibling_files.hpp"
#include "common/parameters/parameters.hpp"

namespace fracture::bake {

struct InputFile {
  std::string bytes;
  MeshFormat format = MeshFormat::kGlb;
  std::vector<SiblingFile> siblings{};
  std::span<const std::byte> view() const { return std::as_bytes(std::span(bytes)); }
};

/// Reads a whole file, a pipe, or standard input (kStandardStream). Returns nothing and sets errno on
/// failure; errno is ECANCELED if a stop was requested while waiting for data.
std::optional<std::string> read_bytes(const std::string& path, const std::stop_token& stop = {});

/// Returns why a file cannot be read, as far as that is known without reading it: it is missing, a folder, or not
/// permitted. Returns nothing for standard input.
std::optional<std::string> fault_of_input(const std::string& path);

/// Prepares the mesh that was read from `path`. Its format is the one in the parameters, else it follows from
/// the file extension, else from the first bytes (kUnknownFormat if none of them decides). Also reads the
/// files that the mesh refers to, except for standard input, which has no folder to find them in.
Expected<InputFile> to_input(const std::string& path, std::string bytes, const RequestParameters& parameters);

}  // namespace fracture::bake
