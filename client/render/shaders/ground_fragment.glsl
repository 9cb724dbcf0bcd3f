in vec3 world_position;
in vec4 clip;
uniform int grid, fade;
layout(location = 0) out vec4 result;

// 1 on lines every `step_length` metres, each a pixel wide.
float lines(vec2 p, float step_length) {
  vec2 q = p / step_length, width = fwidth(q);
  vec2 d = abs(fract(q - 0.5) - 0.5) / max(width, vec2(1e-6));
  return (1.0 - min(min(d.x, d.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
}

void main() {
  vec3 n = vec3(0, 1, 0);
  vec3 albedo = plane.rgb;
  if (grid == 1) {
    float major = pow(10.0, floor(log(sphere.w) / log(10.0) + 0.5));
    albedo *= 1.0 - 0.25 * lines(world_position.xz, major) - 0.10 * lines(world_position.xz, 0.1 * major);
  }
  float sky_share = sky_visibility(world_position, n);
  vec3 irradiance = sky.rgb * sky_share + sun.rgb / PI * max(towards_sun.y, 0.0) * sun_visibility(world_position, n);
  vec3 shown = tone_map(eye.w * albedo * irradiance);
  float distance_out = length(world_position.xz - sphere.xz) / sphere.w;
  float alpha = fade == 1 ? smoothstep(7.0, 2.2, distance_out) : 1.0;
  result = vec4(mix(background_at(clip.y / clip.w), shown, alpha), 1.0);
}
