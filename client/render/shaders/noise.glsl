// Noise on a lattice, identical on every driver because its random numbers come from integers (Jarzynski &
// Olano, "Hash Functions for GPU Rendering", 2020: pcg3d).
uvec3 pcg3d(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}
vec3 random3(ivec3 cell) { return vec3(pcg3d(uvec3(cell)) >> 8u) / 16777216.0; }

// Value noise, 0 … 1.
float noise(vec3 p) {
  vec3 cell = floor(p), f = p - cell;
  ivec3 c = ivec3(cell);
  f = f * f * (3.0 - 2.0 * f);
  float a = mix(random3(c).x, random3(c + ivec3(1, 0, 0)).x, f.x);
  float b = mix(random3(c + ivec3(0, 1, 0)).x, random3(c + ivec3(1, 1, 0)).x, f.x);
  float d = mix(random3(c + ivec3(0, 0, 1)).x, random3(c + ivec3(1, 0, 1)).x, f.x);
  float e = mix(random3(c + ivec3(0, 1, 1)).x, random3(c + ivec3(1, 1, 1)).x, f.x);
  return mix(mix(a, b, f.y), mix(d, e, f.y), f.z);
}

// A sum of octaves, 0 … 1.
float fractal(vec3 p, int octaves) {
  float sum = 0.0, amplitude = 0.5, all = 0.0;
  for (int k = 0; k < octaves; ++k) {
    sum += amplitude * noise(p);
    all += amplitude;
    amplitude *= 0.5;
    p = 2.03 * p + 17.3;
  }
  return sum / all;
}

// Worley, "A Cellular Texture Basis Function", 1996: distance to the nearest point, and that point's random number.
vec2 cellular(vec3 p) {
  ivec3 c = ivec3(floor(p));
  vec2 best = vec2(8.0, 0.0);
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        ivec3 cell = c + ivec3(x, y, z);
        vec3 r = random3(cell);
        float d = distance(p, vec3(cell) + r);
        if (d < best.x) best = vec2(d, fract(r.x * 7.31 + r.z));
      }
  return best;
}
