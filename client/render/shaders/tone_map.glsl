// Khronos PBR Neutral tone mapper, as specified by KhronosGroup/ToneMapping. Base colours stay unchanged;
// highlights are compressed and lose their colour.
vec3 tone_map(vec3 c) {
  const float kF90 = 0.04, kStart = 0.8 - kF90, kDesaturation = 0.15;
  c = max(c, vec3(0.0));
  float x = min(c.r, min(c.g, c.b));
  c -= x <= 2.0 * kF90 ? x - x * x / (4.0 * kF90) : kF90;
  float peak = max(c.r, max(c.g, c.b));
  if (peak <= kStart) return c;
  float new_peak = 1.0 - (1.0 - kStart) * (1.0 - kStart) / (peak + 1.0 - 2.0 * kStart);
  float keep = 1.0 / (kDesaturation * (peak - new_peak) + 1.0);
  return mix(vec3(new_peak), c * new_peak / peak, keep);
}
