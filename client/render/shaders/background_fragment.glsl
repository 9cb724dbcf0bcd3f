in float ndc_y;
layout(location = 0) out vec4 result;
void main() { result = vec4(background_at(ndc_y), 1.0); }
