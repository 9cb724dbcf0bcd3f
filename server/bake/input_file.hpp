// The mesh file of a command, with the files it names beside itself.
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

/// The whole of a file, a pipe or, for kStandardStream, of standard input. Nothing with errno set where it
/// cannot be read; ECANCELED where the stop came while nothing did.
std::optional<std::string> read_bytes(const std::string& path, const std::stop_token& stop = {});

/// The mesh that was read from `path`: its format is as the parameters say, else by the name's ending, else
/// by its first bytes (kUnknownFormat). Reads what it names; standard input has no folder and so can name
/// nothing.
Expected<InputFile> to_input(const std::string& path, std::string bytes, const RequestParameters& parameters);

}  // namespace fracture::bake
