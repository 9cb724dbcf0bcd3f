out vec3 world_position;
out vec4 clip;
void main() {
  vec2 corner = vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
  world_position = vec3(sphere.xz + 30.0 * sphere.w * corner, plane.w).xzy;
  clip = view_projection * vec4(world_position, 1.0);
  gl_Position = clip;
}
