// The view through glass: a ray is bent at entry and at exit (Wyman, "An Approximate Image-Space Approach for
// Interactive Refraction", 2005). It then shows the picture without this glass, blurred for rough surfaces.
uniform sampler2D behind, scene_depth, glass_front, glass_back;

vec3 behind_glass(vec3 p, vec3 n, vec3 v, float ior, float roughness) {
  vec2 here = gl_FragCoord.xy * fog.zw;
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 inside = refract(-v, n, 1.0 / ior);
  vec4 back = texelFetch(glass_back, pixel, 0);
  float in_front = dot(p - eye.xyz, forward.xyz);
  // Without a back face, the glass is a thin pane and the ray goes straight. Otherwise, the ray ends at the
  // plane of the back face.
  float straight = max(back.w - in_front, 0.0) / max(dot(-v, forward.xyz), 0.05), thick = 0.0;
  if (back.w > 0.0) {
    float across = dot(inside, back.xyz);
    thick = across < -0.05 ? straight * dot(-v, back.xyz) / across : straight;
    thick = clamp(thick, 0.0, min(2.0 * straight, 0.5 * sphere.w));
  }
  vec3 leaves = p + thick * inside;
  vec3 out_of = thick > 0.0 ? refract(inside, normalize(back.xyz), ior) : -v;
  if (dot(out_of, out_of) < 0.5) out_of = inside;  // total reflection, which this picture cannot show
  vec4 h = inverse_view_projection * vec4(2.0 * here - 1.0, 2.0 * texelFetch(scene_depth, pixel, 0).r - 1.0, 1.0);
  float gap = clamp(dot(h.xyz / h.w - leaves, forward.xyz) / max(dot(out_of, forward.xyz), 0.2), 0.0, 2.0 * sphere.w);
  vec4 seen = view_projection * vec4(leaves + gap * out_of, 1.0);
  vec2 uv = 0.5 + 0.5 * seen.xy / seen.w;
  // The picture ends at its edge, and things in front of the glass must not be used.
  vec2 edge = smoothstep(vec2(0.0), vec2(0.04), uv) * smoothstep(vec2(0.0), vec2(0.04), 1.0 - uv);
  uv = mix(here, uv, seen.w > 0.0 ? edge.x * edge.y : 0.0);
  if (textureLod(scene_depth, uv, 0.0).r < gl_FragCoord.z) uv = here;
  float level = log2(1.0 / fog.w) * 0.55 * roughness * smoothstep(0.0, 0.3, roughness);
  return textureLod(behind, uv, level).rgb;
}
