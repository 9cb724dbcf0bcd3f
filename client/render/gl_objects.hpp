// OpenGL names that delete themselves. They belong to the context that is current when they are created, and
// it must be current when they are destroyed.
#pragma once

#include <epoxy/gl.h>

#include <string>
#include <utility>

#include "common/base/error.hpp"

namespace fracture::render {

template <void (*Delete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0) Delete(name_);
  }
  GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

namespace gl {
inline void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void delete_texture(GLuint name) { glDeleteTextures(1, &name); }
inline void delete_vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void delete_framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void delete_renderbuffer(GLuint name) { glDeleteRenderbuffers(1, &name); }
inline void delete_query(GLuint name) { glDeleteQueries(1, &name); }
inline void delete_sampler(GLuint name) { glDeleteSamplers(1, &name); }
inline void delete_program(GLuint name) { glDeleteProgram(name); }
}  // namespace gl

using Buffer = GlName<gl::delete_buffer>;
using Texture = GlName<gl::delete_texture>;
using VertexArray = GlName<gl::delete_vertex_array>;
using Framebuffer = GlName<gl::delete_framebuffer>;
using Renderbuffer = GlName<gl::delete_renderbuffer>;
using Query = GlName<gl::delete_query>;
using Sampler = GlName<gl::delete_sampler>;

template <class Name>
Name generate(void (*make)(GLsizei, GLuint*)) {
  GLuint name = 0;
  make(1, &name);
  return Name(name);
}
inline Buffer make_buffer() {
  return generate<Buffer>([](GLsizei n, GLuint* x) { glGenBuffers(n, x); });
}
inline Texture make_texture() {
  return generate<Texture>([](GLsizei n, GLuint* x) { glGenTextures(n, x); });
}
inline VertexArray make_vertex_array() {
  return generate<VertexArray>([](GLsizei n, GLuint* x) { glGenVertexArrays(n, x); });
}
inline Framebuffer make_framebuffer() {
  return generate<Framebuffer>([](GLsizei n, GLuint* x) { glGenFramebuffers(n, x); });
}
inline Renderbuffer make_renderbuffer() {
  return generate<Renderbuffer>([](GLsizei n, GLuint* x) { glGenRenderbuffers(n, x); });
}
inline Query make_query() {
  return generate<Query>([](GLsizei n, GLuint* x) { glGenQueries(n, x); });
}
inline Sampler make_sampler() {
  return generate<Sampler>([](GLsizei n, GLuint* x) { glGenSamplers(n, x); });
}

/// A linked program. Setting a uniform that the compiler removed does nothing. The program must be in use.
class Program {
 public:
  /// Compiles and links. On an error, kGraphicsDriver contains `name` and the compiler's log.
  static Expected<Program> build(const std::string& name, const std::string& vertex,
                                 const std::string& fragment);
  Program() = default;

  void use() const { glUseProgram(program_.get()); }
  GLint location(const char* uniform) const { return glGetUniformLocation(program_.get(), uniform); }
  void set(const char* uniform, int value) const { glUniform1i(location(uniform), value); }
  void set(const char* uniform, float value) const { glUniform1f(location(uniform), value); }
  /// Connects a uniform block to a binding point, if the program has that block.
  void bind_block(const char* block, GLuint binding) const;

 private:
  GlName<gl::delete_program> program_;
};

/// The text of client/render/shaders/<name>.glsl, which is built into the library. An unknown name is a bug.
const char* shader_text(const std::string& name);

}  // namespace fracture::render
