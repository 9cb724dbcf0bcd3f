// Results among meshes: what a bake has written is no input of the next one.
#pragma once

#include <set>
#include <string>

#include "common/import/formats.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

/// By its content: a GLB or glTF that this program's writer made (asset.generator), or that still carries
/// what it said about its fragments (extras.fracture) after another program has written it; an OBJ, PLY or STL whose
/// first words are those of outputs.hpp. False for what cannot be read, and for all other formats.
bool is_result_file(const std::string& path, MeshFormat format);

/// Reads the outputs that the report of a bake says it has made; nothing where it is none or cannot be read.
void add_results_of_report(const std::string& report, std::set<FileIdentity>& results);

}  // namespace fracture::bake
