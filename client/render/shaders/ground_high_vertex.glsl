out vec3 world_position;
// Extends as far as the fog lets anything be seen.
void main() {
  vec2 corner = vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
  vec3 middle = ground.w > 0.5 ? sphere.xyz : eye.xyz;
  world_position = vec3(middle.xz + 2.8 / fog.x * corner, plane.w).xzy;
  gl_Position = view_projection * vec4(world_position, 1.0);
}
