layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec4 uv;
layout(location = 4) in vec4 color;
layout(location = 5) in uint object;

out vec3 world_position, world_normal, source_position;
out vec4 world_tangent, vertex_uv, vertex_color;
flat out uint vertex_object;

void main() {
  mat4 m = object_transform(object);
  vec4 world = m * vec4(position, 1.0);
  world_position = world.xyz;
  // The cofactor matrix transforms normals correctly for any scale. The determinant's sign keeps them
  // pointing outwards.
  mat3 cofactor = mat3(cross(m[1].xyz, m[2].xyz), cross(m[2].xyz, m[0].xyz), cross(m[0].xyz, m[1].xyz));
  float side = sign(dot(m[0].xyz, cofactor[0]));
  world_normal = side * (cofactor * normal);
  world_tangent = vec4(mat3(m) * tangent.xyz, side * tangent.w);
  source_position = (object_transform_at_load(object) * vec4(position, 1.0)).xyz;
  vertex_uv = uv;
  vertex_color = color;
  vertex_object = object;
  gl_Position = view_projection * world;
}
