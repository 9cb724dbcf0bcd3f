layout(location = 0) in vec4 center;  // w: radius, metres
layout(location = 1) in vec4 albedo;  // w: opacity
layout(location = 2) in vec2 turned;  // radians, shape

uniform mat4 view;
uniform sampler2DShadow sun_map;

out vec2 uv;
out float depth_of_puff;
flat out vec4 lit;  // before exposure; w: opacity
flat out float thick;

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  float s = sin(turned.x), c = cos(turned.x);
  vec3 right = vec3(view[0].x, view[1].x, view[2].x), up = vec3(view[0].y, view[1].y, view[2].y);
  vec3 world = center.xyz + center.w * (corner.x * right + corner.y * up);
  gl_Position = view_projection * vec4(world, 1.0);
  depth_of_puff = gl_Position.w;
  vec2 at = mat2(c, s, -s, c) * corner / 1.4143;
  uv = vec2((0.5 + 0.5 * at.x + turned.y) / 4.0, 0.5 + 0.5 * at.y);
  // Dust scatters light in all directions, so a puff has one light, with the sun sampled around its centre.
  float sunny = 0.0;
  if (sun.w < 0.5) {
    sunny = 1.0;
  } else {
    for (int k = 0; k < 4; ++k) {
      vec3 p = center.xyz + 0.5 * center.w * vec3(k == 0 ? 1 : (k == 1 ? -1 : 0), 0, k == 2 ? 1 : (k == 3 ? -1 : 0));
      sunny += 0.25 * texture(sun_map, (sun_matrix * vec4(p + 0.02 * towards_sun.xyz, 1.0)).xyz);
    }
  }
  lit = vec4(albedo.rgb * (0.3 * sun.rgb * sunny + 0.6 * sky.rgb + 0.3 * ground.rgb), albedo.w);
#ifdef HIGH
  lit.rgb *= 0.7;  // the high tier's sun is brighter, and white dust would glow
#endif
  thick = center.w;
}
