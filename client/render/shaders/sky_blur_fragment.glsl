// The sky as mirrored by a rough surface, viewed along the normal: Karis, "Real Shading in Unreal Engine 4",
// 2013. Each sample reads a blurred level that matches its solid angle: Krivanek & Colbert, "Real-time
// Shading with Filtered Importance Sampling", 2008.
uniform samplerCube sky_source;
uniform mat3 face;
uniform int side, source_side;
uniform float roughness;
layout(location = 0) out vec4 result;

float van_der_corput(uint n) {
  n = (n << 16u) | (n >> 16u);
  n = ((n & 0x55555555u) << 1u) | ((n & 0xAAAAAAAAu) >> 1u);
  n = ((n & 0x33333333u) << 2u) | ((n & 0xCCCCCCCCu) >> 2u);
  n = ((n & 0x0F0F0F0Fu) << 4u) | ((n & 0xF0F0F0F0u) >> 4u);
  n = ((n & 0x00FF00FFu) << 8u) | ((n & 0xFF00FF00u) >> 8u);
  return float(n) * 2.3283064365386963e-10;
}

void main() {
  vec3 n = normalize(face * vec3(2.0 * gl_FragCoord.xy / float(side) - 1.0, 1.0));
  vec3 x = normalize(cross(abs(n.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0), n)), y = cross(n, x);
  float a2 = pow(roughness, 4.0), all = 0.0;
  vec3 sum = vec3(0);
  const int kDirections = 32;
  for (int k = 0; k < kDirections; ++k) {
    float u = (float(k) + 0.5) / float(kDirections), turn = 2.0 * PI * van_der_corput(uint(k));
    float c = sqrt((1.0 - u) / (1.0 + (a2 - 1.0) * u)), s = sqrt(1.0 - c * c);
    vec3 h = s * cos(turn) * x + s * sin(turn) * y + c * n;
    vec3 l = 2.0 * c * h - n;
    float n_dot_l = dot(n, l);
    if (n_dot_l <= 0.0) continue;
    float f = c * c * (a2 - 1.0) + 1.0, density = a2 / (PI * f * f) / 4.0;
    float texel_angle = 4.0 * PI / (6.0 * float(source_side * source_side));
    float level = 0.5 * log2(1.0 / (float(kDirections) * density) / texel_angle) + 1.0;
    sum += n_dot_l * textureLod(sky_source, l, max(level, 0.0)).rgb;
    all += n_dot_l;
  }
  result = vec4(sum / max(all, 1e-4), 1.0);
}
