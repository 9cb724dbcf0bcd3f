// Programs made of the files of shaders/, connected to the frame block and to the texture units.
#pragma once

#include <initializer_list>
#include <string>

#include "client/render/gl_objects.hpp"
#include "client/render/tier.hpp"

namespace fracture::render {

inline constexpr GLuint kFrameBinding = 0;  ///< of the uniform block of shaders/frame.glsl

using ShaderParts = std::initializer_list<const char*>;

/// Builds of the named files, in their order; the high tier's have HIGH defined. Leaves the program in use, with its
/// samplers at their units (gpu_model.hpp). kGraphicsDriver where the driver refuses it.
Expected<Program> build_program(const std::string& name, Tier tier, ShaderParts vertex, ShaderParts fragment);

}  // namespace fracture::render
