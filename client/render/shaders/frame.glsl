// The data of the current picture that every program gets; the FrameBlock of frame_block.hpp in std140.
#define MAX_SKY 64
layout(std140) uniform Frame {
  mat4 view_projection, inverse_view_projection, sun_matrix;
  mat4 sky_matrix[MAX_SKY];
  vec4 sky_direction[MAX_SKY];
  vec4 eye;          // w: exposure
  vec4 towards_sun;  // w: softness in texels
  vec4 sun;          // irradiance; w: 1 with shadow
  vec4 sky;          // radiance; w: number of sky directions
  vec4 ground;       // radiance; w: 1 if the camera is orthographic
  vec4 background_top, background_bottom;
  vec4 sphere;       // around the drawn objects: centre, radius
  vec4 plane;        // of the ground: rgb colour, w: height
  vec4 texel;        // metres per texel: sun, sky; 1 / side: sun, sky
  vec4 forward;      // the camera's direction
  vec4 fog;          // high tier: 1 / metres to fog; occlusion radius in metres; 1 / pixels of the picture
};

vec3 background_at(float ndc_y) { return mix(background_bottom.rgb, background_top.rgb, 0.5 + 0.5 * ndc_y); }
