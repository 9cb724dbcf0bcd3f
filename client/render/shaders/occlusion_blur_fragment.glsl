// The mean over the pixels of a four by four square that show the same surface.
uniform sampler2D scene_depth, raw_occlusion;
uniform mat4 inverse_projection;
layout(location = 0) out vec4 result;

float distance_at(ivec2 pixel) {
  vec4 h = inverse_projection * vec4(0.0, 0.0, 2.0 * texelFetch(scene_depth, pixel, 0).r - 1.0, 1.0);
  return -h.z / h.w;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(scene_depth, 0) - 1;
  float here = distance_at(pixel);
  // The change in depth from pixel to pixel that a tilted surface may have.
  float slope = max(abs(dFdx(here)), abs(dFdy(here)));
  float room = 0.004 * abs(here) + min(2.5 * slope, 0.05 * abs(here));
  float sum = 0.0, all = 0.0;
  for (int y = -2; y < 2; ++y)
    for (int x = -2; x < 2; ++x) {
      ivec2 at = clamp(pixel + ivec2(x, y), ivec2(0), last);
      float weight = abs(distance_at(at) - here) < room ? 1.0 : 1e-3;
      sum += weight * texelFetch(raw_occlusion, at, 0).r;
      all += weight;
    }
  result = vec4(sum / all);
}
