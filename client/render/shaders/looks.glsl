// Solid textures by name (looks.hpp). q is the position in the whole object: -1 … 1 in its bounding sphere.
const int kGlass = 1, kWood = 2, kConcrete = 3, kStone = 4, kBrick = 5, kCeramic = 6, kMetal = 7, kIce = 8, kPlaster = 9;
uniform int look;
vec3 grain;  // the object's grain

struct Looked {
  vec3 color;
  float roughness;
  float transmission;
};

// Coordinates along the grain (z) and across it.
vec3 along_grain(vec3 q) {
  vec3 side = abs(grain.y) > 0.9 ? vec3(1, 0, 0) : vec3(0, 1, 0);
  vec3 x = normalize(cross(side, grain)), y = cross(grain, x);
  return vec3(dot(q, x), dot(q, y), dot(q, grain));
}

// Year rings around a pith outside the object, so that boards show a cathedral pattern.
float wood_rings(vec3 g) {
  vec2 pith = vec2(0.35, -1.3);
  float r = length(g.xy - pith + 0.05 * vec2(noise(vec3(2.0 * g.xy, 0.9 * g.z)), noise(vec3(2.0 * g.yx, 0.9 * g.z + 9.0))));
  float ring = fract(19.0 * r + 0.5 * noise(vec3(3.0 * g.xy, 0.6 * g.z)));
  return smoothstep(0.15, 0.80, ring) * (1.0 - smoothstep(0.90, 1.0, ring));
}

// Height of the surface's fine relief, in units of q; gives the normal.
float relief(vec3 q, bool cut) {
  if (look == kWood) {
    vec3 g = along_grain(q);
    return (cut ? 0.007 : 0.0016) * noise(vec3(70.0 * g.xy, 5.0 * g.z)) + (cut ? 0.006 : 0.0) * noise(vec3(22.0 * g.xy, 2.0 * g.z));
  }
  if (look == kConcrete) return (cut ? 0.022 : 0.005) * fractal((cut ? 16.0 : 30.0) * q, 3);
  if (look == kStone) return (cut ? 0.030 : 0.012) * fractal((cut ? 9.0 : 14.0) * q, 4);
  if (look == kBrick) return (cut ? 0.014 : 0.008) * fractal(34.0 * q, 3);
  if (look == kCeramic) return cut ? 0.006 * fractal(40.0 * q, 2) : 0.0;
  if (look == kMetal) return cut ? 0.012 * fractal(22.0 * q, 3) : 0.0004 * noise(vec3(8.0, 240.0, 8.0) * q);
  if (look == kIce) return (cut ? 0.014 : 0.010) * fractal(7.0 * q, 3);
  if (look == kPlaster) return (cut ? 0.020 : 0.0015) * fractal(20.0 * q, 3);
  return 0.0;
}

// In a brick wall (x along it, y up; wall: its low and high corner): a random number for each brick (0 … 1),
// and the distance from the brick's edge in metres.
vec2 brick_at(vec2 p, vec2 size, vec4 wall) {
  vec2 from_end = min(p - wall.xy, wall.zw - p), at = clamp(p, wall.xy + 1e-3, wall.zw - 1e-3) - wall.xy;
  float row = floor(at.y / size.y);
  vec2 brick = vec2(at.x / size.x + 0.5 * mod(row, 2.0), at.y / size.y), inside = fract(brick);
  vec2 edge = min(inside, 1.0 - inside) * size;
  edge = mix(edge, vec2(1.0), vec2(lessThan(from_end, vec2(2e-3))));  // no joints at the ends and the top
  return vec2(random3(ivec3(int(floor(brick.x)), int(row), 7)).x, min(edge.x, edge.y));
}

Looked looked(vec3 q, vec2 p, vec2 brick, vec4 wall, bool cut, float id, vec3 color, float roughness, float transmission) {
  Looked s = Looked(color, roughness, transmission);
  if (look == kWood) {
    vec3 g = along_grain(q);
    float late = wood_rings(g);
    float fibre = noise(vec3(90.0 * g.xy, 3.0 * g.z)), pores = noise(vec3(160.0 * g.xy, 7.0 * g.z));
    s.color = mix(1.35 * color, 0.55 * color, late) * (0.82 + 0.36 * fibre);
    s.color *= mix(1.0, 0.7, smoothstep(0.72, 0.85, pores));
    s.roughness = clamp(roughness + 0.15 * (fibre - 0.5), 0.05, 1.0);
  } else if (look == kConcrete) {
    vec2 pebble = cellular(7.0 * q);
    float cement = fractal(9.0 * q, 4);
    s.color = color * (0.72 + 0.56 * cement);
    if (cut) {
      vec3 stones = mix(vec3(0.30, 0.27, 0.24), vec3(0.55, 0.52, 0.48), pebble.y);
      s.color = mix(s.color, stones, smoothstep(0.36, 0.30, pebble.x));
    } else {
      s.color *= 1.0 - 0.45 * smoothstep(0.16, 0.10, cellular(16.0 * q).x);  // pores
      s.color *= 0.9 + 0.2 * noise(2.5 * q);
    }
  } else if (look == kStone) {
    float layers = fractal(vec3(3.0, 5.0, 3.0) * q, 4), specks = noise(60.0 * q);
    s.color = color * (0.6 + 0.75 * layers);
    s.color = mix(s.color, vec3(0.16, 0.15, 0.15), 0.6 * smoothstep(0.70, 0.85, specks));
    s.color = mix(s.color, vec3(0.62, 0.60, 0.57), 0.5 * smoothstep(0.30, 0.15, specks));
  } else if (look == kBrick) {
    vec2 laid = brick.x > 0.0 ? brick_at(p, brick, wall) : vec2(random3(ivec3(int(id), 5, 11)).x, 1.0);
    s.color = color * mix(vec3(0.70, 0.72, 0.75), vec3(1.25, 1.20, 1.10), laid.x) * (0.75 + 0.5 * fractal(16.0 * q, 3));
    s.color = mix(s.color, vec3(0.20, 0.08, 0.06), 0.5 * smoothstep(0.68, 0.80, noise(38.0 * q)));
    if (!cut) s.color = mix(vec3(0.46, 0.44, 0.40) * (0.8 + 0.4 * fractal(30.0 * q, 2)), s.color, smoothstep(0.006, 0.009, laid.y));
  } else if (look == kCeramic) {
    if (cut) s.color *= 0.85 + 0.3 * fractal(30.0 * q, 2);
  } else if (look == kMetal) {
    s.roughness = clamp(roughness + 0.12 * (fractal(6.0 * q, 3) - 0.5) + 0.10 * (noise(vec3(6.0, 180.0, 6.0) * q) - 0.5), 0.08, 1.0);
  } else if (look == kIce) {
    float cloud = fractal(2.6 * q, 4);
    s.transmission = clamp(transmission * (1.35 - 1.1 * smoothstep(0.35, 0.70, cloud)), 0.0, 1.0);
  } else if (look == kPlaster) {
    s.color *= 0.93 + 0.14 * fractal(5.0 * q, 3);
  }
  return s;
}
