in vec2 ndc;
layout(location = 0) out vec4 result;

void main() {
  vec3 d = forward.xyz;
  if (ground.w < 0.5) {
    vec4 far_away = inverse_view_projection * vec4(ndc, 1.0, 1.0);
    d = normalize(far_away.xyz / far_away.w - eye.xyz);
  }
  vec3 color = sky_with_clouds(d);
  // The disc of the sun: half a degree wide, enlarged by glare.
  color += 4.0 * sun.rgb * smoothstep(0.9998, 0.99995, dot(d, towards_sun.xyz));
  result = vec4(tone_map(eye.w * color), 1.0);
}
