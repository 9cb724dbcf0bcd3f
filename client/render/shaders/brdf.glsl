// How surfaces reflect light: glTF 2.0 specification, appendix B.3 (Trowbridge-Reitz GGX; height-correlated
// Smith visibility, Heitz 2014; Schlick's Fresnel term, 1994).
const float PI = 3.14159265358979;

// The environment's share of reflected light: Karis, "Physically Based Shading on Mobile", 2014, after Lazarov.
vec3 environment_brdf(vec3 f0, float roughness, float n_dot_v) {
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
  vec2 ab = vec2(-1.04, 1.04) * a + r.zw;
  return f0 * ab.x + ab.y;
}

vec3 fresnel(vec3 f0, float v_dot_h) { return f0 + (1.0 - f0) * pow(clamp(1.0 - v_dot_h, 0.0, 1.0), 5.0); }

// D · V of appendix B.3.2, alpha = roughness².
float ggx(float n_dot_h, float n_dot_l, float n_dot_v, float alpha) {
  float a2 = alpha * alpha, f = n_dot_h * n_dot_h * (a2 - 1.0) + 1.0;
  float d = a2 / (PI * f * f);
  float v = 0.5 / max(n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2) +
                      n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2), 1e-5);
  return d * v;
}
