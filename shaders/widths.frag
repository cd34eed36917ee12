#version 330 core
// Pass 5, first half: linearize the depths and cut the view path through the air into lit and shadowed widths.
//
// Written are the distance [m] from the camera to the solid, inf for none, and then cuts as distances [m] from the ray's
// base point: where the shadow begins and ends, and the far end. The class that goes to the depth buffer selects the
// shader that draws the pixel: 0 no air, 1 lit, 2 one lit piece and a shadow, 3 a shadow between two lit pieces, and where
// the method asks for it (HAS_OPEN_CLASS) 4 lit out to the top of the air.

#include "depth.glsl"

uniform Axis u_shadow_axis;
uniform Cone u_shadow;
#ifdef HAS_DEPTH_TEXTURES
uniform sampler2D u_shadow_back;
uniform sampler2D u_shadow_front;
uniform sampler2D u_atmosphere_back;
#endif
#ifdef HAS_PLANET_DEPTH
uniform sampler2D u_planet_depth;
#endif

out vec4 out_cuts;

// Distance [m] from the camera to whatever solid the scene holds. The ground's sphere is part of it, solved and not
// rasterized but for the published variant.
float solid_distance(Pixel pixel, Ray ray) {
  float solid = NOTHING;
#ifdef HAS_PLANET_DEPTH
  solid = own_distance(u_planet_depth, pixel);
#endif
#ifdef HAS_HOST_DEPTH
  solid = min(solid, host_distance(pixel));
#endif
#ifdef HAS_PLANET_DEPTH
#ifdef HAS_PUBLISHED_DEPTH
  return solid;
#endif
#endif
  float ground = ground_distance(ray);
  return ray.air >= 0.0 && ground >= 0.0 ? min(solid, ray.start + ground) : solid;
}

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  float solid = solid_distance(pixel, ray);

#ifdef HAS_DEPTH_TEXTURES
  float air = min(own_distance(u_atmosphere_back, pixel), u_clip_planes.y * pixel.stretch) - ray.start;
  vec2 shadow = vec2(own_distance(u_shadow_front, pixel), own_distance(u_shadow_back, pixel)) - ray.start;
#else
  float air = ray.air;
  vec2 shadow = cone_interval(pixel_axis_ray(pixel, ray, u_shadow_axis), u_shadow, 1.0);
#endif
  float end = ray.air < 0.0 ? 0.0 : clamp(solid - ray.start, 0.0, max(air, 0.0));
  float from = clamp(shadow.x, 0.0, end);
  float to = clamp(shadow.y, from, end);

  bool any_shadow = to > from;
  bool two_pieces = any_shadow && from > 0.0 && to < end;
  float kind = ray.air < 0.0 ? 0.0 : (two_pieces ? 3.0 : (any_shadow ? 2.0 : 1.0));
#ifdef HAS_OPEN_CLASS
  kind += kind == 1.0 && end >= air ? 3.0 : 0.0;
#endif
  out_cuts = vec4(solid >= NOTHING ? uintBitsToFloat(0x7F800000u) : solid, from, to, end);
  gl_FragDepth = 0.25 * kind;
}
