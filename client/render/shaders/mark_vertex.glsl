layout(location = 0) in vec3 corner;   // of the cube of side 2
layout(location = 1) in vec4 center;   // w: radius
layout(location = 2) in vec4 upright;  // normal of the surface; w: rotation about it in radians
layout(location = 3) in vec4 albedo;   // w: opacity; negative: with rays

flat out vec3 middle, x_axis, y_axis, z_axis;
flat out vec4 paint;

void main() {
  vec3 n = upright.xyz, other = abs(n.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0);
  vec3 u = normalize(cross(other, n)), v = cross(n, u);
  float s = sin(upright.w), c = cos(upright.w);
  middle = center.xyz;
  x_axis = (c * u + s * v) / center.w;
  y_axis = (c * v - s * u) / center.w;
  z_axis = n / center.w;
  paint = albedo;
  float r = center.w;
  gl_Position = view_projection * vec4(middle + r * r * (corner.x * x_axis + corner.y * y_axis + 0.6 * corner.z * z_axis), 1.0);
}
