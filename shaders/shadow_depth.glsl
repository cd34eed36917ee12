// Depth of one side of the planet's shadow. The proxy only says where to look; the distance is solved per pixel, or is
// the rasterized one in the published variant.

#include "depth.glsl"

uniform Axis u_shadow_axis;
uniform Cone u_shadow;

in float v_eye_depth;

void write_shadow_depth(bool back) {
#ifdef HAS_PUBLISHED_DEPTH
  gl_FragDepth = encode_depth(v_eye_depth);
#else
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  vec2 interval = cone_interval(pixel_axis_ray(pixel, ray, u_shadow_axis), u_shadow, 1.0);
  float distance = min(ray.start + (back ? interval.y : interval.x), NOTHING);
  if (ray.air < 0.0 || interval.x >= interval.y || ray.start + interval.y <= 0.0) discard;
  gl_FragDepth = encode_depth(distance / pixel.stretch);
#endif
}
