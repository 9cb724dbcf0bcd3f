// Light and shadows of the low tier.
uniform sampler2DShadow sun_map;
uniform sampler2DArrayShadow sky_maps;

// Percentage-closer filtering (Reeves, Salesin, Cook, 1987) over a Vogel disc. All pixels use the same disc,
// because turning it from pixel to pixel left a pattern in the shadows. The map's own filter smooths between
// two taps. The point is moved along its normal by the distance that a texel can hide (Holbert, "Saying
// Goodbye to Shadow Acne", 2011).
float sun_visibility(vec3 p, vec3 n) {
  if (sun.w < 0.5) return 1.0;
  float facing = clamp(dot(n, towards_sun.xyz), 0.0, 1.0);
  float radius = max(towards_sun.w, 0.75);
  p += n * texel.x * (1.0 + radius * (1.0 - facing));
  vec3 q = (sun_matrix * vec4(p, 1.0)).xyz;
  float lit = 0.0;
  const int kTaps = 16;
  for (int k = 0; k < kTaps; ++k) {
    float r = sqrt((float(k) + 0.5) / float(kTaps)), angle = 2.39996323 * float(k);
    lit += texture(sun_map, vec3(q.xy + radius * texel.z * r * vec2(cos(angle), sin(angle)), q.z));
  }
  return lit / float(kTaps);
}

// Share of the sky's light (weighted by the cosine) that reaches the point; 1 without sky shadows.
float sky_visibility(vec3 p, vec3 n) {
  int count = int(sky.w);
  if (count == 0) return 1.0;
  const float kRadius = 3.0;  // texels: neighbouring directions overlap
  vec3 moved = p + n * (1.0 + kRadius) * texel.y;
  float all = 0.02, lit = 0.02;
  for (int k = 0; k < count; ++k) {
    float weight = dot(n, sky_direction[k].xyz) + 0.15;  // slightly below the horizon, to soften the edge
    if (weight <= 0.0) continue;
    vec3 q = (sky_matrix[k] * vec4(moved, 1.0)).xyz;
    float angle = 2.39996323 * float(k);
    all += weight;
    lit += weight * texture(sky_maps, vec4(q.xy + kRadius * sqrt(fract(0.618034 * float(k) + 0.3)) * texel.w * vec2(cos(angle), sin(angle)), float(k), q.z));
  }
  return lit / all;
}

// A soft rectangle of light around `towards`, for reflections.
float soft_box(vec3 r, vec3 towards, vec3 up, vec2 half_size, float blur) {
  vec3 x = normalize(cross(up, towards)), y = cross(towards, x);
  float depth = dot(r, towards);
  if (depth <= 0.05) return 0.0;
  vec2 d = abs(vec2(dot(r, x), dot(r, y))) / depth;
  vec2 edge = smoothstep(half_size + blur, half_size - min(vec2(blur), half_size), d);
  return edge.x * edge.y * min(half_size.x * half_size.y, 1.0) / min((half_size.x + blur) * (half_size.y + blur), 1.0);
}

// The mirrored surroundings: ground and sky, and two studio lamps.
vec3 environment(vec3 r, float roughness) {
  float blur = 0.04 + 0.9 * roughness * roughness;
  vec3 horizon = mix(sky.rgb, vec3(1.0), 0.25);
  vec3 color = mix(ground.rgb, horizon, smoothstep(-blur, blur, r.y));
  color = mix(color, sky.rgb * 0.85, smoothstep(0.0, 0.8, r.y));
  color += 2.6 * soft_box(r, normalize(vec3(-0.55, 0.62, 0.56)), vec3(0, 1, 0), vec2(0.45, 0.30), blur);
  color += 1.5 * soft_box(r, normalize(vec3(0.92, 0.28, -0.1)), vec3(0, 1, 0), vec2(0.16, 0.75), blur);
  return color;
}
