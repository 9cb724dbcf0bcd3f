// Dust that fades near surfaces: Lorach, "Soft Particles", 2007.
in vec2 uv;
in float depth_of_puff;
flat in vec4 lit;
flat in float thick;
uniform sampler2D puff_shapes, scene_depth;
layout(location = 0) out vec4 result;

void main() {
  float alpha = lit.w * texture(puff_shapes, uv).r;
  if (alpha < 0.004) discard;
  vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(textureSize(scene_depth, 0)) - 1.0;
  vec4 p = inverse_view_projection * vec4(ndc, 2.0 * texelFetch(scene_depth, ivec2(gl_FragCoord.xy), 0).r - 1.0, 1.0);
  float behind = dot(p.xyz / p.w - eye.xyz, forward.xyz) - depth_of_puff;
  alpha *= clamp(behind / (0.6 * thick) + 0.35, 0.0, 1.0);
  alpha *= clamp(depth_of_puff / 0.5 - 0.4, 0.0, 1.0);  // fades near the eye
  result = vec4(tone_map(eye.w * lit.rgb) * alpha, alpha);
}
