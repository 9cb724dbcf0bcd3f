in vec2 mask_uv;
in float mask_alpha;
uniform sampler2D base_color_map;
uniform float cutoff;        // negative: no mask
uniform float alpha_factor;
uniform float coverage;      // share of the light that is blocked

// Interleaved gradient noise: Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", 2014.
float dither(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

void main() {
  if (cutoff >= 0.0 && alpha_factor * mask_alpha * texture(base_color_map, mask_uv).a < cutoff) discard;
  if (coverage < 1.0 && dither(gl_FragCoord.xy) >= coverage) discard;
}
