#include "client/view/debug_lines.hpp"

#include <cstddef>

namespace fracture::view {

Expected<DebugLines> DebugLines::create() {
  DebugLines lines;
  auto program = render::Program::build("lines",
                                        "#version 330 core\n"
                                        "layout(location = 0) in vec3 position;\n"
                                        "layout(location = 1) in vec3 color;\n"
                                        "uniform mat4 view_projection;\n"
                                        "out vec3 shade;\n"
                                        "void main() {\n"
                                        "  shade = color;\n"
                                        "  gl_Position = view_projection * vec4(position, 1.0);\n"
                                        "}\n",
                                        "#version 330 core\n"
                                        "in vec3 shade;\n"
                                        "layout(location = 0) out vec4 result;\n"
                                        "void main() { result = vec4(shade, 1.0); }\n");
  if (!program) return tl::unexpected(program.error());
  lines.program_ = std::move(*program);
  lines.array_ = render::make_vertex_array();
  lines.buffer_ = render::make_buffer();
  glBindVertexArray(lines.array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, lines.buffer_.get());
  for (const GLuint k : {0u, 1u}) {
    glEnableVertexAttribArray(k);
    glVertexAttribPointer(k, 3, GL_FLOAT, GL_FALSE, sizeof(Point),
                          reinterpret_cast<const void*>(k * offsetof(Point, color)));
  }
  glBindVertexArray(0);
  return lines;
}

void DebugLines::draw(const render::Camera& camera, bool through) {
  if (!vertices_.empty()) {
    program_.use();
    const glm::mat4 matrix = camera.view_projection();
    glUniformMatrix4fv(program_.location("view_projection"), 1, GL_FALSE, &matrix[0][0]);
    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(Point)), vertices_.data(),
                 GL_STREAM_DRAW);
    if (through) glDisable(GL_DEPTH_TEST);
    glDrawArrays(GL_LINES, 0, static_cast<GLsizei>(vertices_.size()));
    glEnable(GL_DEPTH_TEST);
    glBindVertexArray(0);
  }
  vertices_.clear();
}

}  // namespace fracture::view
