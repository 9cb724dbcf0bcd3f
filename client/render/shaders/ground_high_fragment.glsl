in vec3 world_position;
uniform int grid;
uniform sampler2D screen_occlusion;
layout(location = 0) out vec4 result;

// Flagstones: closeness to a joint (1: in it), and a random number of each flagstone.
vec2 paving(vec2 p, float side) {
  vec2 q = p / side, inside = abs(fract(q) - 0.5), width = fwidth(q);
  // Joints are softer than a pixel, and fainter if a pixel is wider than the joint.
  const float kJoint = 0.008;
  vec2 joint = smoothstep(0.5 - kJoint - width, vec2(0.5 - 0.5 * kJoint) + 0.3 * width, inside) * min(vec2(1.0), 2.5 * kJoint / width);
  float seen = 1.0 - smoothstep(0.10, 0.45, max(width.x, width.y));
  return vec2(max(joint.x, joint.y) * seen, mix(0.5, random3(ivec3(floor(q), 5)).x, seen));
}

void main() {
  vec3 n = vec3(0, 1, 0), p = world_position, albedo = plane.rgb;
  float scale = pow(10.0, floor(log(max(sphere.w, 1e-6)) / log(10.0) + 0.5));
  vec2 q = p.xz / scale;
  float pixel = length(fwidth(q));
  // Stains, and grain that is only drawn near enough not to flicker.
  float tone = 0.14 * (fractal(vec3(2.1 * q, 2.0), 5) - 0.5) + 0.10 * (noise(vec3(0.7 * q, 9.0)) - 0.5);
  tone += 0.12 * (noise(vec3(260.0 * q, 1.0)) - 0.5) * (1.0 - smoothstep(0.001, 0.0035, pixel));
  tone += 0.10 * (noise(vec3(900.0 * q, 4.0)) - 0.5) * (1.0 - smoothstep(0.0003, 0.001, pixel));
  float roughness = 0.62;
  if (grid == 1) {
    vec2 flag = paving(p.xz, 0.1 * scale);
    albedo *= (1.0 + 0.20 * (flag.y - 0.5)) * (1.0 - 0.50 * flag.x);
    roughness += 0.16 * (flag.y - 0.5);
  }
  albedo *= 1.0 + tone;
  float open = texelFetch(screen_occlusion, ivec2(gl_FragCoord.xy), 0).r;
  float sky_share = min(sky_visibility(p, n), open), sunny = sun_visibility(p, n);
  vec3 v = ground.w > 0.5 ? -forward.xyz : normalize(eye.xyz - p);
  vec3 irradiance = sky.rgb * sky_share + sun.rgb / PI * max(towards_sun.y, 0.0) * sunny;
  vec3 mirrored = environment(reflect(-v, n), roughness) * environment_brdf(vec3(0.04), roughness, max(v.y, 1e-3));
  vec3 color = albedo * irradiance + mirrored * sky_share * mix(0.6, 1.0, sunny);
  result = vec4(tone_map(fogged(eye.w * color, p)), 1.0);
}
