// The table of objects, eleven texels each. See GpuModel::set_states.
uniform samplerBuffer object_table;

vec4 object_texel(uint object, int texel) { return texelFetch(object_table, int(object) * 11 + texel); }
mat4 object_matrix(uint object, int first_row) {
  return transpose(mat4(object_texel(object, first_row), object_texel(object, first_row + 1),
                        object_texel(object, first_row + 2), vec4(0, 0, 0, 1)));
}
mat4 object_transform(uint object) { return object_matrix(object, 0); }
mat4 object_transform_at_load(uint object) { return object_matrix(object, 3); }
vec4 object_tint(uint object) { return object_texel(object, 6); }
float object_fragment_id(uint object) { return object_texel(object, 7).x; }
vec3 object_grain(uint object) { return object_texel(object, 7).yzw; }
vec4 object_look_frame(uint object) { return object_texel(object, 8); }  // centre and radius
vec2 object_brick(uint object) { return object_texel(object, 9).xy; }    // size; 0: none
vec4 object_wall(uint object) { return vec4(object_texel(object, 9).zw, object_texel(object, 10).xy); }  // low, high
