// What an output was made of, for build systems.
#pragma once

#include <string>

#include "server/bake/input_file.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// One make rule, which make and Ninja read: the output, then the mesh, the files that it names and that
/// are there (buffers, textures, material libraries), and the file of rules where there is one (its path is not empty).
std::string depfile_text(const BakeJob& job, const InputFile& input, const std::string& rules);
/// The same as a file, written whole. False with errno set.
bool write_depfile(const std::string& path, const BakeJob& job, const InputFile& input,
                   const std::string& rules);

}  // namespace fracture::bake
