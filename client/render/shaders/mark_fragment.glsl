// A decal on anything inside its box, found by the picture's depth: Persson, "Volume Decals", GPU Pro 2,
// 2011.
flat in vec3 middle, x_axis, y_axis, z_axis;
flat in vec4 paint;
uniform sampler2D scene_depth;
layout(location = 0) out vec4 result;

void main() {
  float depth = texelFetch(scene_depth, ivec2(gl_FragCoord.xy), 0).r;
  vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(textureSize(scene_depth, 0)) - 1.0;
  vec4 h = inverse_view_projection * vec4(ndc, 2.0 * depth - 1.0, 1.0);
  vec3 p = h.xyz / h.w, d = p - middle;
  vec3 q = vec3(dot(d, x_axis), dot(d, y_axis), dot(d, z_axis));
  float r = length(q.xy);
  if (depth >= 1.0 || r > 1.0 || abs(q.z) > 0.5) discard;
  vec3 n = normalize(z_axis);
  // The position varies the marks, so that no two look alike.
  vec3 cell = 7.0 * middle;
  float angle = atan(q.y, q.x);
  float edge = noise(vec3(2.5 * q.xy, 0.0) + cell), grain = noise(vec3(14.0 * q.xy, 3.0) + cell);
  float inner = paint.w < 0.0 ? 0.30 : 0.75;  // with rays, the spot is small
  float spot = smoothstep(inner, 0.25 * inner, r * (0.6 + 0.8 * edge)) * (0.45 + 0.55 * grain);
  float rays = 0.0;
  if (paint.w < 0.0) {
    const float kRays = 9.0;
    float sector = (angle / (2.0 * PI) + 0.5) * kRays;
    vec3 dice = random3(ivec3(floor(sector), ivec2(101.0 * cell.xz)));
    float bent = 0.25 * (noise(vec3(5.0 * r, floor(sector), 1.0) + cell) - 0.5);
    float off = abs(fract(sector) - 0.5 - 0.5 * (dice.x - 0.5) - bent) * 2.0 * PI * r / kRays;
    float reach = 0.35 + 0.65 * dice.y;
    rays = smoothstep(0.028 * (1.0 - r / reach) + 0.006, 0.0, off) * step(r, reach);
  }
  float alpha = clamp(abs(paint.w) * spot + 0.8 * rays, 0.0, 1.0) * smoothstep(1.0, 0.85, r);
  if (alpha < 0.01) discard;
  float sky_share = sky_visibility(p, n);
  vec3 light = mix(ground.rgb, sky.rgb * sky_share, 0.5 + 0.5 * n.y);
  float facing = dot(n, towards_sun.xyz);
  if (facing > 0.0) light += sun.rgb / PI * facing * sun_visibility(p, n);
  vec3 color = paint.w < 0.0 ? mix(paint.rgb, vec3(0.03), rays) : paint.rgb;
  result = vec4(tone_map(eye.w * color * light) * alpha, alpha);
}
