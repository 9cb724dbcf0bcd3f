// Turns light into colours: exposure by the picture's mean (Reinhard et al., "Photographic Tone Reproduction
// for Digital Images", 2002; within narrow bounds, independent of earlier pictures), bloom, tone mapping.
in vec2 ndc;
uniform sampler2D source, bloom;
layout(location = 0) out vec4 result;

void main() {
  vec2 uv = 0.5 + 0.5 * ndc;
  vec4 c = textureLod(source, uv, 0.0), mean = textureLod(source, vec2(0.5), 16.0);
  float brightness = dot(mean.rgb, vec3(0.2126, 0.7152, 0.0722)) / max(mean.a, 1e-3);
  const float kMiddle = 0.42;
  float exposure = clamp(sqrt(kMiddle / max(brightness, 1e-3)), 0.90, 1.12);
  const float kBloom = 0.03;  // strength of the bloom
  vec3 glare = kBloom * textureLod(bloom, uv, 0.0).rgb;
  result = vec4(tone_map(exposure * (c.rgb + glare)), max(c.a, clamp(max(glare.r, max(glare.g, glare.b)), 0.0, 1.0)));
}
