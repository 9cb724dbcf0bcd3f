// The point where light leaves glass: normal on the eye's side, and distance from the eye's plane.
in vec3 world_position, world_normal;
layout(location = 0) out vec4 result;

void main() { result = vec4(normalize(-world_normal), dot(world_position - eye.xyz, forward.xyz)); }
