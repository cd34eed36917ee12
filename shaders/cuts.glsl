// Where solids and the planet's shadow cut the view path through the air: by depth textures or by closed forms.

#include "depth.glsl"
#include "shadow_axis.glsl"
#ifdef HAS_TERMINATOR
#include "night.glsl"
#endif

uniform Cone u_shadow;
#ifdef HAS_TERMINATOR
uniform Cone u_dusk;
#endif
#ifdef HAS_DEPTH_TEXTURES
uniform sampler2D u_shadow_back;
uniform sampler2D u_shadow_front;
uniform sampler2D u_atmosphere_back;
#endif
#ifdef HAS_PLANET_DEPTH
uniform sampler2D u_planet_depth;
#endif

#ifdef HAS_LONG_PATHS
const float DENSEST = 0.25;  // of k at the top, below which a tangent point makes a lit path long
#endif

// Distance [m] from the camera to what the depth textures hold; NOTHING where that is nothing.
float drawn_distance(ivec2 texel, Pixel pixel) {
  float solid = NOTHING;
#ifdef HAS_PLANET_DEPTH
  solid = own_distance(u_planet_depth, texel, pixel);
#endif
#ifdef HAS_HOST_DEPTH
  solid = min(solid, host_distance(texel, pixel));
#endif
  return solid;
}

// Distance [m] from the base point to the ground, NOTHING where the ray does not meet it. The ground's sphere is solved, and
// rasterized in the published variant alone.
float ground_end(Ray ray) {
#ifdef HAS_PLANET_DEPTH
#ifdef HAS_PUBLISHED_DEPTH
  return NOTHING;
#endif
#endif
  float ground = ground_distance(ray);
  return ray.air >= 0.0 && ground >= 0.0 ? ground : NOTHING;
}

// Where the ray's line enters and leaves the planet's shadow, as distances [m] from its base point.
vec2 shadow_along(ivec2 texel, Pixel pixel, Ray ray) {
#ifdef HAS_DEPTH_TEXTURES
  return vec2(own_distance(u_shadow_front, texel, pixel), own_distance(u_shadow_back, texel, pixel)) - ray.start;
#else
  return cone_interval(pixel_axis_ray(pixel, ray, u_shadow_axis), u_shadow, 1.0);
#endif
}

// Where the ray leaves the air, as a distance [m] from its base point, if no solid ends it before.
float air_end(ivec2 texel, Pixel pixel, Ray ray) {
#ifdef HAS_DEPTH_TEXTURES
  return min(own_distance(u_atmosphere_back, texel, pixel), u_clip_planes.y * pixel.stretch) - ray.start;
#else
  return ray.air;
#endif
}

// The distance [m] from the camera to the solid, and then cuts as distances [m] from the ray's base point: where the
// shadow begins and ends, and the far end.
vec4 path_cuts(ivec2 texel, Pixel pixel, Ray ray) {
  float solid = drawn_distance(texel, pixel);
  float ground = ground_end(ray);
  float air = air_end(texel, pixel, ray);
  vec2 shadow = shadow_along(texel, pixel, ray);
  // Not the distance of the ground from the camera: from far away that has lost the digits that count.
  float end = ray.air < 0.0 ? 0.0 : clamp(min(solid - ray.start, ground), 0.0, max(air, 0.0));
  solid = min(solid, ray.start + ground);
#ifdef HAS_TERMINATOR
  shadow = night_or_dusk(shadow, cone_interval(pixel_axis_ray(pixel, ray, u_shadow_axis), u_dusk, 1.0), end);
#endif
  float from = clamp(shadow.x, 0.0, end);
  return vec4(solid, from, clamp(shadow.y, from, end), end);
}

// Whether a path has a dark part, or is cut in two by the dusk of a finite disc.
bool is_cut(vec4 cuts) {
#ifdef HAS_TERMINATOR
  if (cuts.y > 0.0 && cuts.z < cuts.w) return true;
#endif
  return cuts.z > cuts.y;
}

// The same for a shader that draws paths of every kind: without a cut there is one lit piece, not two that meet where no
// shadow begins.
vec4 solved_cuts(ivec2 texel, Pixel pixel, Ray ray) {
  vec4 cuts = path_cuts(texel, pixel, ray);
  return is_cut(cuts) ? cuts : cuts.xwww;
}
