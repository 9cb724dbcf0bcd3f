layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 center;  // w: half the length
layout(location = 3) in vec4 turn;    // axis, radians
layout(location = 4) in vec4 albedo;  // w: length over width

out vec3 world_position, world_normal;
flat out vec3 color;

// Rodrigues' rotation.
vec3 turned(vec3 p) {
  float s = sin(turn.w), c = cos(turn.w);
  return c * p + s * cross(turn.xyz, p) + (1.0 - c) * dot(turn.xyz, p) * turn.xyz;
}

void main() {
  vec3 thin = vec3(1.0, 1.0 / albedo.w, 1.0 / albedo.w);
  world_position = center.xyz + center.w * turned(position * thin);
  world_normal = turned(normal / thin);
  color = albedo.rgb;
  gl_Position = view_projection * vec4(world_position, 1.0);
}
