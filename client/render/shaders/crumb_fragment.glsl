in vec3 world_position, world_normal;
flat in vec3 color;
layout(location = 0) out vec4 result;

void main() {
  vec3 n = normalize(world_normal);
  float sky_share = sky_visibility(world_position, n);
  vec3 light = mix(ground.rgb * mix(0.55, 1.0, sky_share), sky.rgb * sky_share, 0.5 + 0.5 * n.y);
  float facing = dot(n, towards_sun.xyz);
  if (facing > 0.0) light += sun.rgb / PI * facing * sun_visibility(world_position, n);
  result = vec4(tone_map(eye.w * color * light), 1.0);
}
