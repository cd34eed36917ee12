#version 330 core
// The air at the corners of the tiles: light and opacity, transmittance and the code of the path.

#include "composite.glsl"
#include "adaptive.glsl"

layout(location = 0) out vec4 out_light;
layout(location = 1) out vec4 out_clear;

void main() {
  vec2 number = gl_FragCoord.xy - 0.5;
  Pixel pixel = make_pixel(sample_place(number));
  Ray ray = pixel_ray(pixel);
  ivec2 texel = sample_texel(number);
  vec4 cuts = solved_cuts(texel, pixel, ray);
  Scattered air = air_radiance(sample_place(number), pixel, ray, vec4(0.0, cuts.yzw));
  out_light = vec4(u_irradiance * air.radiance, opacity(air));
  out_clear = vec4(air.transmittance, path_code(texel, pixel, ray, cuts));
}
