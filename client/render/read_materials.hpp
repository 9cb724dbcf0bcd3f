// Converts glTF 2.0 materials for the shader. Internal to read_model.cpp.
#pragma once

#include "client/render/model.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::render {

/// Fills materials (with glTF's default one at the end), pictures and warnings. Throws
/// nlohmann::json::exception for values of a wrong type.
void read_materials(const MaterialLibrary& library, Model& model);

}  // namespace fracture::render
