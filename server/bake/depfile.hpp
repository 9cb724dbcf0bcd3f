// Dependency files for build systems: the files that an output was made from.
#pragma once

#include <string>

#include "server/bake/input_file.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Returns one make rule for make or Ninja. The target is the output. The prerequisites are the mesh, the
/// existing files that it refers to (buffers, textures, material libraries), and the rule file unless `rules`
/// is empty.
std::string depfile_text(const BakeJob& job, const InputFile& input, const std::string& rules);
/// Writes depfile_text() atomically. Returns false and sets errno on failure.
bool write_depfile(const std::string& path, const BakeJob& job, const InputFile& input,
                   const std::string& rules);

}  // namespace fracture::bake
