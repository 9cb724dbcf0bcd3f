// Writes depth only, with holes where the mask cuts.
in vec4 vertex_uv, vertex_color;
uniform sampler2D base_color_map;
uniform vec4 base_color, more;  // as in surface_fragment.glsl
uniform int uv_set[5];

void main() {
  if (more.z >= 0.0 && base_color.a * vertex_color.a * texture(base_color_map, uv_set[0] == 0 ? vertex_uv.xy : vertex_uv.zw).a < more.z) discard;
}
