// The table of objects: eight texels each. See GpuScene::set_states.
uniform samplerBuffer object_table;

mat4 object_matrix(uint object, int first_row) {
  int at = int(object) * 8 + first_row;
  return transpose(mat4(texelFetch(object_table, at), texelFetch(object_table, at + 1), texelFetch(object_table, at + 2),
                        vec4(0, 0, 0, 1)));
}
mat4 object_transform(uint object) { return object_matrix(object, 0); }
mat4 object_transform_at_load(uint object) { return object_matrix(object, 3); }
vec4 object_tint(uint object) { return texelFetch(object_table, int(object) * 8 + 6); }
float object_fragment_id(uint object) { return texelFetch(object_table, int(object) * 8 + 7).x; }
