// Outputs that are made of an answer: OBJ with its materials and textures, PLY, STL.
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

/// Why a file may not be written; nothing: it may.
using Objection = std::function<std::optional<Error>(const std::string& path)>;

/// Writes the output, whose folder is there, and what belongs beside it, each file whole or not at all; the output itself comes
/// last, so that it names nothing that is not there, and is the first of the list. `answer`: a GLB. kFileAccess: the
/// reason; what lies in the place of a texture is not lost: only textures that the MTL there names, or equal ones, are
/// written over. kCancelled; kInternal: it is no answer.
Expected<std::vector<WrittenFile>> write_output(const std::string& path, OutputKind kind,
                                                std::span<const std::uint8_t> answer,
                                                outputs::VertexColors colors, const Objection& objection,
                                                const std::stop_token& stop);

/// An answer of the format that answer_format() says, in its folder, which is made, or to standard output: as it is, or as write_output() does it.
/// `source`: the format of the mesh, which decides what its vertex colours mean. Errors are those of write_output().
Expected<std::vector<WrittenFile>> write_answer(const std::string& path, OutputKind kind,
                                                const std::vector<std::uint8_t>& answer, const Digest& digest,
                                                MeshFormat source, const Objection& objection,
                                                const std::stop_token& stop);

/// Is there something that a user may have made, which the materials of an OBJ would be written over?
bool is_foreign_mtl(const std::string& path);

/// "sha256:…" of a file, read block by block; nothing where it cannot be read.
std::optional<std::string> digest_of_file(const std::string& path);

}  // namespace fracture::bake
