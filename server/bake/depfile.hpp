// What an output was made of, for build systems.
#pragma once

#include <string>

#include "server/bake/input_file.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// One make rule, which make and Ninja read: the output, then the mesh and the files that it names and that
/// are there (buffers, textures, material libraries).
std::string depfile_text(const BakeJob& job, const InputFile& input);
/// The same as a file, written whole. False with errno set.
bool write_depfile(const std::string& path, const BakeJob& job, const InputFile& input);

}  // namespace fracture::bake
