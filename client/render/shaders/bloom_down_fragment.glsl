// Halves the size. Thirteen overlapping readings prevent flicker: Jimenez, "Next Generation Post Processing
// in Call of Duty: Advanced Warfare", 2014.
in vec2 ndc;
uniform sampler2D source;
uniform float threshold;  // only brighter light passes; 0: all
uniform float dearest;    // upper limit of a reading's brightness
layout(location = 0) out vec4 result;

vec3 reading(vec2 uv) {
  vec3 c = textureLod(source, uv, 0.0).rgb;
  if (threshold <= 0.0) return c;
  float peak = max(c.r, max(c.g, c.b));
  return c * smoothstep(threshold, 1.8 * threshold, peak) * min(1.0, dearest / max(peak, 1e-4));
}

void main() {
  vec2 uv = 0.5 + 0.5 * ndc, t = 1.0 / vec2(textureSize(source, 0));
  vec3 sum = 0.125 * reading(uv);
  for (int k = 0; k < 4; ++k) {
    vec2 corner = vec2((k & 1) * 2 - 1, (k >> 1) * 2 - 1);
    sum += 0.125 * reading(uv + t * corner) + 0.03125 * reading(uv + 2.0 * t * corner);
  }
  sum += 0.0625 * (reading(uv + vec2(2.0 * t.x, 0)) + reading(uv - vec2(2.0 * t.x, 0)) + reading(uv + vec2(0, 2.0 * t.y)) +
                   reading(uv - vec2(0, 2.0 * t.y)));
  result = vec4(sum, 1.0);
}
