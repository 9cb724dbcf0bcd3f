in vec3 world_position, world_normal, source_position;
in vec4 world_tangent, vertex_uv, vertex_color;
flat in uint vertex_object;

uniform sampler2D base_color_map, metallic_roughness_map, normal_map, occlusion_map, emissive_map;
uniform vec4 base_color;  // linear
uniform vec4 pbr;         // metallic, roughness, transmission, ior
uniform vec4 more;        // normal scale (0: no map), occlusion strength, alpha cutoff (negative: none), 1: alpha blends
uniform vec3 emissive;
uniform int uv_set[5];
uniform int interior, highlight;
#ifdef HIGH
uniform sampler2D screen_occlusion;
uniform int layer;  // 0: opaque; for glass 1: hidden behind the nearest front face, 2: the nearest front face
#endif

// Two outputs for blending: the surface's own light, and the share of the light from behind that passes
// through.
layout(location = 0, index = 0) out vec4 reflected;
layout(location = 0, index = 1) out vec4 transmitted;

vec2 uv_of(int slot) { return uv_set[slot] == 0 ? vertex_uv.xy : vertex_uv.zw; }

// Tangent frame from the picture's derivatives, if the file has no tangents: Schueler, "Normal Mapping
// without Precomputed Tangents", ShaderX 5, 2006.
mat3 derived_frame(vec3 n, vec2 uv) {
  vec3 dp1 = dFdx(world_position), dp2 = dFdy(world_position);
  vec2 d1 = dFdx(uv), d2 = dFdy(uv);
  vec3 p2 = cross(dp2, n), p1 = cross(n, dp1);
  vec3 t = p2 * d1.x + p1 * d2.x, b = p2 * d1.y + p1 * d2.y;
  float scale = inversesqrt(max(max(dot(t, t), dot(b, b)), 1e-20));
  return mat3(t * scale, b * scale, n);
}

vec3 shading_normal(bool front) {
  vec3 n = normalize(world_normal);
  if (!front) n = -n;
  if (more.x == 0.0) return n;
  vec2 uv = uv_of(2);
  vec3 mapped = 2.0 * texture(normal_map, uv).xyz - 1.0;
  mapped.xy *= more.x;
  if (world_tangent.w != 0.0) {
    vec3 t = normalize(world_tangent.xyz - n * dot(n, world_tangent.xyz));
    vec3 b = cross(normalize(world_normal), t) * world_tangent.w;
    return normalize(mat3(t, b, n) * mapped);
  }
  // glTF's v axis points down and its green channel up, so the bitangent is -dp/dv.
  mat3 frame = derived_frame(n, uv);
  return normalize(frame[0] * mapped.x - frame[1] * mapped.y + frame[2] * mapped.z);
}

// The normal of a surface with relief(): n minus the height's slope along the surface. Slopes are computed at
// the fragment's original position and turned with it.
vec3 relief_normal(vec3 n, vec3 q, bool cut) {
  if (look == 0) return n;
  const float kStep = 0.004;
  float h = relief(q, cut);
  vec3 slope = vec3(relief(q + vec3(kStep, 0, 0), cut) - h, relief(q + vec3(0, kStep, 0), cut) - h,
                    relief(q + vec3(0, 0, kStep), cut) - h) / kStep;
  mat3 turn = mat3(object_transform(vertex_object)) * inverse(mat3(object_transform_at_load(vertex_object)));
  slope = turn * slope;
  return normalize(n - (slope - n * dot(n, slope)));
}

void main() {
#ifdef HIGH
  // The nearest front face of glass is drawn last, over everything that it refracts.
  const float kSameDepth = 4e-7;
  if (layer > 0 && gl_FrontFacing) {
    bool nearest = gl_FragCoord.z <= texelFetch(glass_front, ivec2(gl_FragCoord.xy), 0).r + kSameDepth;
    if (nearest != (layer == 2)) discard;
  }
#endif
  vec4 base = base_color * vertex_color * texture(base_color_map, uv_of(0));
  if (more.z >= 0.0 && base.a < more.z) discard;
  if (more.w < 0.5) base.a = 1.0;
  vec4 metal_rough = texture(metallic_roughness_map, uv_of(1));
  float metallic = pbr.x * metal_rough.b, roughness = pbr.y * metal_rough.g, transmission = pbr.z;
  bool cut = interior == 1;
  vec3 n = shading_normal(gl_FrontFacing);
  vec3 flat_normal = normalize(gl_FrontFacing ? world_normal : -world_normal);
  if (look != 0) {
    vec4 frame = object_look_frame(vertex_object);
    grain = object_grain(vertex_object);
    vec3 q = (source_position - frame.xyz) / frame.w;
    Looked s = looked(q, source_position.xy, object_brick(vertex_object), object_wall(vertex_object), cut,
                      object_fragment_id(vertex_object), base.rgb, roughness, transmission);
    base.rgb = s.color;
    roughness = s.roughness;
    transmission = s.transmission;
    n = relief_normal(n, q, cut);
  }
  vec4 tint = object_tint(vertex_object);
  if (highlight == 1) tint = cut ? vec4(0.90, 0.23, 0.03, 1.0) : vec4(0.42, 0.44, 0.47, 1.0);
  base.rgb = mix(base.rgb, tint.rgb, tint.a);
  metallic *= 1.0 - tint.a;
  transmission *= 1.0 - tint.a;
  roughness = mix(roughness, 0.6, tint.a);

  vec3 v = ground.w > 0.5 ? -forward.xyz : normalize(eye.xyz - world_position);
  float n_dot_v = max(dot(n, v), 1e-3);
  float dielectric = pow((pbr.w - 1.0) / (pbr.w + 1.0), 2.0);
  vec3 f0 = mix(vec3(dielectric), base.rgb, metallic);
  vec3 diffuse = base.rgb * (1.0 - metallic) * (1.0 - transmission);
  float alpha = max(roughness * roughness, 0.004);

  float sky_share = sky_visibility(world_position, flat_normal);
  float occlusion = 1.0 + more.y * (texture(occlusion_map, uv_of(3)).r - 1.0);
#ifdef HIGH
  float open = layer == 0 ? texelFetch(screen_occlusion, ivec2(gl_FragCoord.xy), 0).r : 1.0;
  // Bright corners light themselves (fit from Jimenez et al. 2016). Mirrors see past near objects (Lagarde &
  // de Rousiers, "Moving Frostbite to Physically Based Rendering", 2014).
  vec3 lit_corner = max(vec3(open), ((2.0404 * diffuse - 0.3324) * open + (-4.7951 * diffuse + 0.6417)) * open * open +
                                        (2.7552 * diffuse + 0.6903) * open);
  float mirror_open = clamp(pow(n_dot_v + open, exp2(-16.0 * roughness - 1.0)) - 1.0 + open, 0.0, 1.0);
#else
  const vec3 lit_corner = vec3(1.0);
  const float mirror_open = 1.0;
#endif

  // The sun.
  vec3 l = towards_sun.xyz, h = normalize(l + v);
  float n_dot_l = dot(n, l);
  vec3 from_diffuse = vec3(0), from_gloss = vec3(0);
  if (n_dot_l > 0.0 && dot(flat_normal, l) > 0.0) {
    vec3 light = sun.rgb * n_dot_l * sun_visibility(world_position, flat_normal);
    vec3 f = fresnel(f0, dot(v, h));
    from_diffuse += light * (1.0 - f) * diffuse / PI;
    from_gloss += light * f * ggx(max(dot(n, h), 0.0), n_dot_l, n_dot_v, alpha);
  }
  // Hemispheres: sky above, and ground below (light reflected by the ground where the object does not shade
  // it).
  float above = 0.5 + 0.5 * n.y;
  // Occlusion by large parts is already in sky_share, so corners do not count it again.
  vec3 sky_seen = min(vec3(sky_share), lit_corner);
#ifdef HIGH
  // Surfaces that hide the sky are lit themselves, and return some of that light from all sides.
  const float kBack = 0.4, kLeast = 0.75;
#else
  const float kBack = 0.0, kLeast = 0.55;
#endif
  vec3 back = kBack * (1.0 - sky_share) * ground.rgb * lit_corner;
  vec3 ambient = mix(ground.rgb * mix(kLeast, 1.0, sky_share) * lit_corner, sky.rgb * sky_seen + back, above);
  from_diffuse += ambient * occlusion * diffuse;
  vec3 mirror = environment(reflect(-v, n), roughness);
  from_gloss += mirror * environment_brdf(f0, roughness, n_dot_v) * occlusion * mix(sky_share, 1.0, 0.3 + 0.5 * transmission) * mirror_open;

  vec3 glow = emissive * texture(emissive_map, uv_of(4)).rgb;
  vec3 through = vec3(1.0 - base.a);
  if (transmission > 0.0) {
    // Thin-walled: absorption grows with the path through the wall, which is longer at grazing angles.
    vec3 absorbed = pow(max(base.rgb, vec3(1e-3)), vec3(0.5 / max(n_dot_v, 0.18)));
    through = transmission * absorbed * (1.0 - fresnel(f0, n_dot_v)) * base.a + (1.0 - base.a);
  }
  vec3 shown = eye.w * (base.a * from_diffuse + from_gloss * (more.w > 0.5 ? base.a : 1.0) + glow);
#ifdef HIGH
  shown = layer == 0 ? fogged(shown, world_position) : shown * (1.0 - fog_at(world_position));
  if (layer == 2) {
    vec3 seen = transmission > 0.0 ? behind_glass(world_position, n, v, pbr.w, roughness)
                                   : texelFetch(behind, ivec2(gl_FragCoord.xy), 0).rgb;
    reflected = vec4(tone_map(shown + through * seen), 1.0 - dot(through, vec3(1.0 / 3.0)));
    transmitted = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
#endif
  reflected = vec4(tone_map(shown), 1.0 - dot(through, vec3(1.0 / 3.0)));
  transmitted = vec4(through, 1.0);
}
