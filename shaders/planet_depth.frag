#version 330 core
// Pass 3, geometry: where the ray meets the ground's sphere.

#include "depth.glsl"

layout(location = 0) out float out_distance;  // m, along the ray

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  float ground = ground_distance(ray);
  if (ray.air < 0.0 || ground < 0.0) discard;
  out_distance = ray.start + ground;
  gl_FragDepth = encode_depth(out_distance / pixel.stretch);
}
