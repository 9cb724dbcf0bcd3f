// Writes outputs that are converted from an answer: OBJ with its materials and textures, PLY and STL.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/outputs/outputs.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

struct WrittenFile {
  std::string path;
  Digest digest;
  std::uint64_t bytes = 0;
};

/// Returns why a file must not be written, or nothing if it may be.
using Objection = std::function<std::optional<Error>(const std::string& path)>;

/// Converts `answer` (a GLB) and writes the output with its material and texture files. The folder must
/// exist. Each file is written completely or not at all. The output itself is written last, so that it never
/// refers to missing files; it is the first element of the result. Existing files in place of textures are
/// only overwritten if the existing MTL names them or their bytes are equal. Errors: kFileAccess with the
/// reason, kCancelled, and kInternal if `answer` is invalid.
Expected<std::vector<WrittenFile>> write_output(const std::string& path, OutputKind kind,
                                                std::span<const std::uint8_t> answer,
                                                outputs::VertexColors colors, const Objection& objection,
                                                const std::stop_token& stop);

/// Writes an answer (in the format that answer_format() gives) to a file, whose folder is created, or to
/// standard output: unchanged for GLB and glTF, else with write_output(). `source` is the mesh's format,
/// which decides how its vertex colours are converted. Errors: as for write_output().
Expected<std::vector<WrittenFile>> write_answer(const std::string& path, OutputKind kind,
                                                const std::vector<std::uint8_t>& answer, const Digest& digest,
                                                MeshFormat source, const Objection& objection,
                                                const std::stop_token& stop);

/// Returns whether `path` exists and is not an MTL that a bake has written. Such a file must not be
/// overwritten.
bool is_foreign_mtl(const std::string& path);

/// Returns "sha256:…" of a file, which is read block by block, or nothing if it cannot be read.
std::optional<std::string> digest_of_file(const std::string& path);

}  // namespace fracture::bake
