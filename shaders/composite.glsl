// Pass 5, the light of one pixel: what the air takes from the light behind it, what it scatters into the ray, the sun.

#include "shadow_axis.glsl"
#ifdef HAS_AIR
#ifdef HAS_SEGMENTS
#include "segments.glsl"
#endif
#ifdef HAS_MARCH
#include "march.glsl"
#endif
#ifdef HAS_TABLE3D
#include "table3d.glsl"
#endif
#ifdef HAS_TABLE4D
#include "table4d.glsl"
#endif
#ifdef HAS_TABLE_ECLIPSE
#include "table_eclipse.glsl"
#endif
#ifdef HAS_WIDTHS
#include "path_widths.glsl"
#endif
#ifdef HAS_MULTIPLE_VIEW
#include "multiple.glsl"
#include "multiple_view.glsl"
#endif
#ifdef HAS_ECLIPSE_VIEW
#include "eclipse_view.glsl"
#endif
#ifdef HAS_SHADE
#include "shade.glsl"
#endif
#endif
#ifdef HAS_SUN_DISC
#include "sun_disc.glsl"
#endif

uniform vec3 u_irradiance;
#ifdef HAS_ECLIPSE
uniform vec3 u_camera_position;  // m
#endif

#ifdef HAS_SUN_DISC
// The sun's disc behind the air, where no solid hides it.
vec3 disc_radiance(Pixel pixel) {
  float hidden = 0.0;
#ifdef HAS_MOONS
  hidden = behind_moons(pixel.direction);
#endif
  return u_irradiance * sun_disc(pixel.direction, hidden);
}
#endif

#ifdef HAS_AIR
// Transmittance and light of all orders [1/sr], per unit irradiance. fragment = the pixel's place in the window, cuts as in
// segments.glsl.
Scattered air_radiance(vec2 fragment, Pixel pixel, Ray ray, vec4 cuts) {
  vec3 across = cross(pixel.direction, u_shadow_axis.direction);
  float nu = -dot(pixel.direction, u_shadow_axis.direction);
  vec2 sun = vec2(-base_height(pixel, ray, u_shadow_axis, -nu), nu);
#ifdef HAS_ECLIPSE
  eclipse_base = base_point(pixel, ray, u_camera_position);
  eclipse_direction = pixel.direction;
#endif
  Scattered air = scatter(ray, sun, dot(across, across), cuts);
#ifdef HAS_TABLE_ECLIPSE
  air.radiance *= path_visibility(ray, sun, cuts);
#endif
#ifdef HAS_MULTIPLE_VIEW
#ifdef HAS_HIGH_CAMERA
  vec3 multiple = multiple_inscatter(ray, pixel.direction, sun, cuts.w, air.transmittance);
#else
  vec3 multiple = multiple_inscatter(fragment, cuts.w, air.transmittance);
#endif
#ifdef HAS_ECLIPSE_VIEW
  multiple *= exp(eclipse_remainder(fragment, ray, cuts.w));
#endif
#ifdef HAS_SHADE
  multiple *= shade(air.visibility);
#else
#ifdef HAS_ECLIPSE
  multiple *= air.visibility;  // rings alone, wide against the paths of scattered light
#endif
#endif
  air.radiance += multiple;
#endif
  return air;
}

// How much of the background the air hides.
float opacity(Scattered air) { return 1.0 - dot(air.transmittance, vec3(1.0 / 3.0)); }
#endif
