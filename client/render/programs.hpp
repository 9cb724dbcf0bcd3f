// Builds programs from the files in shaders/ and connects them to the frame block and the texture units.
#pragma once

#include <initializer_list>
#include <string>

#include "client/render/gl_objects.hpp"
#include "client/render/tier.hpp"

namespace fracture::render {

inline constexpr GLuint kFrameBinding = 0;  ///< binding of the uniform block of shaders/frame.glsl

using ShaderParts = std::initializer_list<const char*>;

/// Builds a program from the named files, in this order; HIGH is defined for the high tier. Leaves the
/// program in use, with its samplers set to their units (gpu_model.hpp). kGraphicsDriver if the driver
/// rejects it.
Expected<Program> build_program(const std::string& name, Tier tier, ShaderParts vertex, ShaderParts fragment);

}  // namespace fracture::render
