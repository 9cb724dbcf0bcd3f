// Recognizes the results of earlier bakes among meshes, so that they do not become inputs.
#pragma once

#include <set>
#include <string>

#include "common/import/formats.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

/// Checks the content. A GLB or glTF is a result if this program wrote it (asset.generator), or if another
/// program rewrote it but kept its fragment data (extras.fracture). An OBJ, PLY or STL is a result if it
/// begins with the words in outputs.hpp. Returns false for unreadable files and other formats.
bool is_result_file(const std::string& path, MeshFormat format);

/// Adds the outputs that a bake report lists as made. Adds nothing if the file is not a report or cannot be
/// read.
void add_results_of_report(const std::string& report, std::set<FileIdentity>& results);

}  // namespace fracture::bake
