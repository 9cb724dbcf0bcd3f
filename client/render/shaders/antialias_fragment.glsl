// Smooths edges that multisampling misses (in glass, of shadows and glints). A pixel of high contrast is
// blended along the edge seen in its neighbours' brightness. Based on Lottes, "FXAA", 2009.
in vec2 ndc;
uniform sampler2D source;
layout(location = 0) out vec4 result;

float bright(vec3 c) { return sqrt(dot(c, vec3(0.299, 0.587, 0.114))); }

void main() {
  vec2 uv = 0.5 + 0.5 * ndc, t = fog.zw;
  vec4 here = textureLod(source, uv, 0.0);
  float m = bright(here.rgb);
  float ne = bright(textureLod(source, uv + 0.5 * vec2(t.x, t.y), 0.0).rgb), nw = bright(textureLod(source, uv + 0.5 * vec2(-t.x, t.y), 0.0).rgb);
  float se = bright(textureLod(source, uv + 0.5 * vec2(t.x, -t.y), 0.0).rgb), sw = bright(textureLod(source, uv - 0.5 * t, 0.0).rgb);
  float low = min(m, min(min(ne, nw), min(se, sw))), high = max(m, max(max(ne, nw), max(se, sw)));
  result = here;
  if (high - low < max(0.06, 0.16 * high)) return;
  vec2 gradient = vec2(ne + se - nw - sw, ne + nw - se - sw);
  vec2 along = vec2(-gradient.y, gradient.x);
  along /= max(max(abs(along.x), abs(along.y)), 1e-4);
  vec4 near = 0.5 * (textureLod(source, uv + 0.5 * t * along, 0.0) + textureLod(source, uv - 0.5 * t * along, 0.0));
  vec4 wide = 0.5 * near + 0.25 * (textureLod(source, uv + 1.5 * t * along, 0.0) + textureLod(source, uv - 1.5 * t * along, 0.0));
  float of_wide = bright(wide.rgb);
  // A wider mean outside the range has met another edge.
  result = mix(here, of_wide < low || of_wide > high ? near : wide, 0.75);
}
