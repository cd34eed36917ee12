#version 330 core
// Pass 4: where the ray leaves the air through its top.

#include "depth.glsl"

in float v_eye_depth;

void main() {
#ifdef HAS_PUBLISHED_DEPTH
  gl_FragDepth = encode_depth(v_eye_depth);
#else
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  if (ray.air < 0.0) discard;
  gl_FragDepth = encode_depth((ray.start + ray.air) / pixel.stretch);
#endif
}
