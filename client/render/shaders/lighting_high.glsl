// Light and shadows of the high tier, without noise between neighbouring pixels.
uniform sampler2DShadow sun_map;
uniform sampler2D sun_depths;         // the same map, without comparison
uniform sampler2DShadow clear_map;    // casters that let light through
uniform sampler2DArrayShadow sky_maps;
uniform samplerCube sky_map;          // levels by roughness
const float kRoughestLevel = 5.0;     // as in sky_light.cpp
const float kClearShadow = 0.35;      // as in surface_pass.cpp
const float kBrightest = 24.0;        // upper limit for a single point of light

// Percentage-closer filtering on a regular grid, wider the farther away the caster is: Fernando,
// "Percentage-Closer Soft Shadows", 2005. Neighbouring taps overlap to avoid a pattern.
float sun_visibility(vec3 p, vec3 n) {
  if (sun.w < 0.5) return 1.0;
  float facing = clamp(dot(n, towards_sun.xyz), 0.0, 1.0);
  vec3 moved = p + n * texel.x * (1.5 + 4.0 * (1.0 - facing));
  vec3 q = (sun_matrix * vec4(moved, 1.0)).xyz;
  if (any(greaterThan(abs(q - 0.5), vec3(0.5)))) return 1.0;
  float found = 0.0, gap = 0.0;
  const int kSearch = 2;
  for (int y = -kSearch; y <= kSearch; ++y)
    for (int x = -kSearch; x <= kSearch; ++x) {
      float before = q.z - textureLod(sun_depths, q.xy + 3.0 * texel.z * vec2(x, y), 0.0).r;
      float in_front = smoothstep(0.0, 0.002, before);
      found += in_front;
      gap += in_front * before;
    }
  // The map covers 2.2 radii in depth and 2 in width. The sun's disc is blurred as if it were four times as
  // large.
  const float kSpread = 0.036;
  float wide = found > 0.0 ? kSpread * 1.1 * gap / found / texel.z : 0.0;  // texels
  const int kReach = 3;
  float stride = clamp(wide / float(kReach), 0.45 + 0.18 * towards_sun.w, 1.9), lit = 0.0, all = 0.0;
  for (int y = -kReach; y <= kReach; ++y)
    for (int x = -kReach; x <= kReach; ++x) {
      vec2 d = vec2(x, y) / (float(kReach) + 1.0);
      float weight = (1.0 - d.x * d.x) * (1.0 - d.y * d.y);
      weight *= weight;
      vec2 at = q.xy + stride * texel.z * vec2(x, y);
      lit += weight * texture(sun_map, vec3(at, q.z)) * (1.0 - kClearShadow * (1.0 - texture(clear_map, vec3(at, q.z))));
      all += weight;
    }
  return lit / all;
}

// Share of the sky's light (weighted by the cosine) that reaches the point; 1 without sky shadows.
float sky_visibility(vec3 p, vec3 n) {
  int count = int(sky.w);
  if (count == 0) return 1.0;
  const float kRadius = 2.5;  // texels
  vec3 moved = p + n * (1.0 + kRadius) * texel.y;
  float all = 0.02, lit = 0.02;
  for (int k = 0; k < count; ++k) {
    float weight = dot(n, sky_direction[k].xyz) + 0.15;
    if (weight <= 0.0) continue;
    vec3 q = (sky_matrix[k] * vec4(moved, 1.0)).xyz;
    float turn = 2.39996323 * float(k);
    vec2 a = kRadius * texel.w * vec2(cos(turn), sin(turn)), b = vec2(-a.y, a.x);
    all += weight;
    lit += 0.25 * weight * (texture(sky_maps, vec4(q.xy + a, float(k), q.z)) + texture(sky_maps, vec4(q.xy - a, float(k), q.z)) +
                            texture(sky_maps, vec4(q.xy + 0.5 * b, float(k), q.z)) + texture(sky_maps, vec4(q.xy - 0.5 * b, float(k), q.z)));
  }
  return lit / all;
}

// The mirrored surroundings.
vec3 environment(vec3 r, float roughness) { return textureLod(sky_map, r, kRoughestLevel * roughness).rgb; }

// Light stays linear until the picture is finished.
vec3 tone_map(vec3 c) { return clamp(c, vec3(0.0), vec3(kBrightest)); }

// 1 in complete fog, which begins at the eye, or at the drawn objects if all lines of sight are parallel.
float fog_at(vec3 p) {
  float way = distance(p, ground.w > 0.5 ? sphere.xyz : eye.xyz) * fog.x;
  return 1.0 - exp(-way * way);
}
vec3 fogged(vec3 color, vec3 p) {
  vec3 d = p - eye.xyz;
  return mix(color, eye.w * clear_sky(normalize(vec3(d.x, 0.0, d.z) + 1e-6)), fog_at(p));
}
