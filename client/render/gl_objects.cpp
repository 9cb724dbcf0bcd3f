#include "client/render/gl_objects.hpp"

#include <vector>

namespace fracture::render {
namespace {

void delete_shader(GLuint name) { glDeleteShader(name); }
using Shader = GlName<delete_shader>;

Expected<Shader> compile(const std::string& name, GLenum stage, const std::string& text) {
  Shader shader(glCreateShader(stage));
  const char* source = text.c_str();
  glShaderSource(shader.get(), 1, &source, nullptr);
  glCompileShader(shader.get());
  GLint good = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &good);
  if (good == GL_TRUE) return shader;
  GLint length = 0;
  glGetShaderiv(shader.get(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::kGraphicsDriver, "The driver refuses the shader " + name + ": " + log.c_str());
}

}  // namespace

Expected<Program> Program::build(const std::string& name, const std::string& vertex,
                                 const std::string& fragment) {
  Expected<Shader> v = compile(name + " (vertex)", GL_VERTEX_SHADER, vertex);
  if (!v) return tl::unexpected(v.error());
  Expected<Shader> f = compile(name + " (fragment)", GL_FRAGMENT_SHADER, fragment);
  if (!f) return tl::unexpected(f.error());
  Program result;
  result.program_ = GlName<gl::delete_program>(glCreateProgram());
  const GLuint program = result.program_.get();
  glAttachShader(program, v->get());
  glAttachShader(program, f->get());
  glLinkProgram(program);
  GLint good = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good == GL_TRUE) return result;
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::kGraphicsDriver, "The driver cannot link the program " + name + ": " + log.c_str());
}

void Program::bind_block(const char* block, GLuint binding) const {
  const GLuint index = glGetUniformBlockIndex(program_.get(), block);
  if (index != GL_INVALID_INDEX) glUniformBlockBinding(program_.get(), index, binding);
}

}  // namespace fracture::render
