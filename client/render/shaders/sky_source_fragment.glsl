// One face of the surroundings that surfaces mirror: the sky above, and below it the ground, which fades into
// fog.
uniform mat3 face;
uniform int side;
layout(location = 0) out vec4 result;

void main() {
  vec3 d = normalize(face * vec3(2.0 * gl_FragCoord.xy / float(side) - 1.0, 1.0));
  vec3 above = sky_with_clouds(d);
  vec3 lit = plane.rgb * (sky.rgb + sun.rgb / PI * max(towards_sun.y, 0.0));
  vec3 below = mix(clear_sky(vec3(d.x, 0.0, d.z)), lit, 1.0 - exp(9.0 * min(d.y, 0.0)));
  result = vec4(d.y > 0.0 ? above : below, 1.0);
}
