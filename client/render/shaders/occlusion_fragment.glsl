// The unoccluded share of a point's surroundings, from the depth of neighbouring pixels: Jimenez, Wu, Pesce,
// Jarabo, "Practical Real-Time Strategies for Accurate Indirect Occlusion", 2016. (Finds the horizons to both
// sides in some planes through the view, and integrates the cosine between them in closed form.)
uniform sampler2D scene_depth;
uniform mat4 inverse_projection, projection;
layout(location = 0) out vec4 result;

float depth_at(ivec2 pixel) { return texelFetch(scene_depth, clamp(pixel, ivec2(0), textureSize(scene_depth, 0) - 1), 0).r; }

// In the camera's space: x right, y up, -z forward.
vec3 place(ivec2 pixel, float depth) {
  vec4 h = inverse_projection * vec4(2.0 * (vec2(pixel) + 0.5) * fog.zw - 1.0, 2.0 * depth - 1.0, 1.0);
  return h.xyz / h.w;
}
vec3 place_at(ivec2 pixel) { return place(pixel, depth_at(pixel)); }

// Difference to the neighbour on the same surface, the one whose depth differs less.
vec3 slope(ivec2 pixel, vec3 p, ivec2 step_by) {
  vec3 a = place_at(pixel + step_by) - p, b = p - place_at(pixel - step_by);
  return abs(a.z) < abs(b.z) ? a : b;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = depth_at(pixel);
  if (depth >= 1.0) {
    result = vec4(1.0);
    return;
  }
  vec3 p = place(pixel, depth);
  vec3 n = normalize(cross(slope(pixel, p, ivec2(1, 0)), slope(pixel, p, ivec2(0, 1))));
  bool parallel = projection[3][3] == 1.0;
  vec3 v = parallel ? vec3(0, 0, 1) : normalize(-p);
  if (dot(n, v) < 0.0) n = -n;
  p += 1e-3 * fog.y * n + 2e-4 * abs(p.z) * v;  // so depth steps do not look like walls
  float radius = fog.y;
  float reach = radius * projection[1][1] / (parallel ? 1.0 : -p.z) * 0.5 / fog.w;  // pixels
  reach = min(reach, 0.25 / fog.w);
  if (reach < 1.5) {
    result = vec4(1.0);
    return;
  }
  // Each of these values occurs once in every square of four by four pixels, over which the blur averages.
  int in_square = (pixel.x & 3) + 4 * (pixel.y & 3);
  float turn = float((in_square * 5) & 15) / 16.0, start = float((in_square * 11 + 3) & 15) / 16.0;
  const int kPlanes = 3, kSteps = 5;
  float seen = 0.0;
  for (int k = 0; k < kPlanes; ++k) {
    float angle = PI * (float(k) + turn) / float(kPlanes);
    vec2 along = vec2(cos(angle), sin(angle));
    vec3 side = vec3(along, 0.0) - v * dot(vec3(along, 0.0), v), axis = normalize(cross(side, v));
    vec3 flat_n = n - axis * dot(n, axis);
    float length_n = max(length(flat_n), 1e-4);
    float lean = sign(dot(side, flat_n)) * acos(clamp(dot(flat_n, v) / length_n, -1.0, 1.0));
    float horizon[2];
    for (int s = 0; s < 2; ++s) {
      float towards = s == 0 ? -1.0 : 1.0, highest = cos(lean + towards * 0.5 * PI);
      float lowest = highest;
      for (int j = 0; j < kSteps; ++j) {
        float t = (float(j) + start + 0.15) / float(kSteps);
        ivec2 at = pixel + ivec2(round(towards * max(reach * t * t, float(j) + 1.0) * along));
        float d = depth_at(at);
        if (d >= 1.0) continue;  // the sky occludes nothing
        vec3 to = place(at, d) - p;
        float far_off = length(to);
        float fade = 1.0 - smoothstep(0.6, 1.0, far_off / radius);
        highest = max(highest, mix(lowest, dot(to, v) / max(far_off, 1e-6), fade));
      }
      horizon[s] = towards * acos(clamp(highest, -1.0, 1.0));
    }
    float left = lean + max(horizon[0] - lean, -0.5 * PI), right = lean + min(horizon[1] - lean, 0.5 * PI);
    float arc = 0.25 * (-cos(2.0 * left - lean) + cos(lean) + 2.0 * left * sin(lean)) +
                0.25 * (-cos(2.0 * right - lean) + cos(lean) + 2.0 * right * sin(lean));
    seen += length_n * arc;
  }
  result = vec4(clamp(seen / float(kPlanes), 0.0, 1.0));
}
