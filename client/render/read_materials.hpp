// glTF 2.0 materials as the shader takes them. Internal to read_model.cpp.
#pragma once

#include "client/render/model.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::render {

/// Fills materials (plus glTF's default one at the end), pictures and warnings. Values of a wrong type throw
/// nlohmann::json::exception.
void read_materials(const MaterialLibrary& library, Model& model);

}  // namespace fracture::render
