layout(location = 0) in vec3 position;
layout(location = 3) in vec4 uv;
layout(location = 4) in vec4 color;
layout(location = 5) in uint object;

uniform int map;  // -1: the sun; otherwise a direction of the sky
uniform int alpha_uv;
out vec2 mask_uv;
out float mask_alpha;

void main() {
  vec4 world = object_transform(object) * vec4(position, 1.0);
  mat4 light = map < 0 ? sun_matrix : sky_matrix[map];
  vec3 p = (light * world).xyz;  // 0 … 1
  mask_uv = alpha_uv == 0 ? uv.xy : uv.zw;
  mask_alpha = color.a;
  gl_Position = vec4(2.0 * p - 1.0, 1.0);
}
