// Doubles the size, with a tent filter of nine readings; added to the target.
in vec2 ndc;
uniform sampler2D source;
layout(location = 0) out vec4 result;

void main() {
  vec2 uv = 0.5 + 0.5 * ndc, t = 1.0 / vec2(textureSize(source, 0));
  vec3 sum = vec3(0);
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      sum += float((2 - abs(x)) * (2 - abs(y))) / 16.0 * textureLod(source, uv + t * vec2(x, y), 0.0).rgb;
  result = vec4(sum, 1.0);
}
