#version 330 core
// Pass 5, second half: the scene behind the air, dimmed, plus the light that the air scatters into the ray.

#include "composite.glsl"
#ifdef HAS_SOLVED_CUTS
#include "cuts.glsl"
#else
uniform sampler2D u_cuts;
#endif
#ifdef HAS_BACKGROUND
uniform sampler2D u_background;
#endif

#include "output.glsl"

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
#ifdef HAS_SOLVED_CUTS
  vec4 cuts = solved_cuts(texel, pixel, ray);
#else
  vec4 cuts = texelFetch(u_cuts, texel, 0);
#endif
  vec3 background = vec3(0.0);
#ifdef HAS_BACKGROUND
  background = texelFetch(u_background, texel, 0).rgb;
#endif
#ifdef HAS_SUN_DISC
  background += cuts.x > 1.0e29 ? disc_radiance(pixel) : vec3(0.0);  // no solid
#endif
#ifdef HAS_AIR
  Scattered air = air_radiance(gl_FragCoord.xy, pixel, ray, vec4(0.0, cuts.yzw));
  out_color = vec4(air.transmittance * background + u_irradiance * air.radiance, opacity(air));
#ifdef HAS_IN_PLACE
  if (ray.air < 0.0 && background == vec3(0.0)) discard;  // what is there keeps its bits
  out_passed = vec4(air.transmittance, 1.0);
#endif
#else
  out_color = vec4(background, 0.0);
#endif
}
