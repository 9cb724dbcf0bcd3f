// A clear sky as a function of the direction: light scattered once by air and haze. Optical depths of air at
// 650, 550 and 450 nm: Hansen & Travis, "Light Scattering in Planetary Atmospheres", 1974. Air mass: Kasten &
// Young, "Revised Optical Air Mass Tables", 1989. Around the sun: Henyey & Greenstein, 1941.
const vec3 kAir = vec3(0.049, 0.097, 0.221);
const float kHaze = 0.035;
const float kTurbid = 1.9;           // multiplies the air, so that the sky is not too dark overhead
const float kMostAir = 11.0;         // air masses: as from a hill; in a plain, everything distant is white
const float kDaylight = 1.5;         // brightness of infinitely deep air, relative to the mean sky

float air_mass(float height) {
  float degrees_up = degrees(asin(clamp(height, 0.0, 1.0)));
  return 1.0 / (max(height, 0.0) + 0.50572 * pow(degrees_up + 6.07995, -1.6364));
}

// Also defined at and below the horizon, because it is the fog's colour.
vec3 clear_sky(vec3 d) {
  vec3 scattered = 1.0 - exp(-(kTurbid * kAir + kHaze) * min(air_mass(d.y), kMostAir));
  const float kForward = 0.76;
  float c = dot(normalize(vec3(d.x, max(d.y, 0.0), d.z)), towards_sun.xyz);
  float haze = (1.0 - kForward * kForward) / (4.0 * PI * pow(1.0 + kForward * kForward - 2.0 * kForward * c, 1.5));
  return kDaylight * dot(sky.rgb, vec3(1.0 / 3.0)) * scattered + 0.05 * sun.rgb * haze * smoothstep(0.0, 0.12, d.y);
}

// Thin clouds on a plane high above; none at the horizon.
float cloud_cover(vec3 d) {
  if (d.y < 0.03) return 0.0;
  vec2 at = 1.1 * d.xz / (d.y + 0.10);
  vec2 bent = at + 0.7 * vec2(noise(vec3(0.9 * at, 3.0)), noise(vec3(0.9 * at, 8.0)));
  float thick = fractal(vec3(vec2(0.8, 1.5) * bent, 0.0), 5);
  return 0.75 * smoothstep(0.46, 0.80, thick) * smoothstep(0.03, 0.30, d.y);
}

vec3 sky_with_clouds(vec3 d) {
  vec3 white = 0.62 * sky.rgb / max(sky.b, 1e-3) + 0.12 * sun.rgb;
  return mix(clear_sky(d), white, cloud_cover(d));
}
