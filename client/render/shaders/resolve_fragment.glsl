// Combines each pixel's samples into one colour. Bright samples have less weight, so that edges of glaring
// areas are smooth after tone mapping: Karis, "High-Quality Temporal Supersampling", 2014.
uniform sampler2DMS samples;
uniform int count;
layout(location = 0) out vec4 result;

void main() {
  vec4 sum = vec4(0.0);
  float all = 0.0;
  for (int k = 0; k < count; ++k) {
    vec4 c = texelFetch(samples, ivec2(gl_FragCoord.xy), k);
    float weight = 1.0 / (1.0 + max(c.r, max(c.g, c.b)));
    sum += vec4(weight * c.rgb, c.a / float(count));
    all += weight;
  }
  result = vec4(sum.rgb / all, sum.a);
}
