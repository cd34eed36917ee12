// The lit ground (Schafhitzel et al. 2007, eq. 9-12): sunlight through the air, reflected by a Lambertian surface.

#include "transmittance.glsl"
#ifdef HAS_TERMINATOR
#include "terminator.glsl"
#endif
#include "phase.glsl"
#include "camera.glsl"
#include "maps.glsl"
#ifdef HAS_MULTIPLE
#include "multiple.glsl"
#endif
#ifdef HAS_ECLIPSE
#include "eclipse.glsl"
#endif
#ifdef HAS_TERMINATOR_MOONS
#include "terminator_moons.glsl"
#endif
#ifdef HAS_RATIO
#include "eclipse_multiple.glsl"
#endif
#ifdef HAS_WATER
#include "sky.glsl"
#include "water.glsl"
#endif

uniform Axis u_shadow_axis;
uniform vec3 u_irradiance;
uniform vec3 u_ground_albedo;
#ifdef HAS_COLOR_MAP
uniform sampler2D u_color_map;
#endif
#ifdef HAS_RELIEF
uniform sampler2D u_relief_map;  // slope to the east, slope to the north, altitude [m], share of sea
#endif

#ifdef HAS_WATER
// Light of sun and sky that the sea mirrors into the eye. to_eye = unit vector, level_light = irradiance of a level plane
// by the sun, left = what the moons leave of multiple scattering.
vec3 mirrored(vec3 up, vec3 to_eye, vec3 sun, vec3 level_light, vec3 left) {
  float mu = max(dot(up, to_eye), 1.0e-3);
  float mu_s = dot(up, sun);
  vec3 reflected = 2.0 * dot(up, to_eye) * up - to_eye;
  // Waves turn the mirror up where it is seen at a slant, so that it never shows the haze on the horizon alone.
  float above = max(dot(up, reflected), 0.06);
#ifdef HAS_ECLIPSE
  eclipse_base = up * u_bottom_radius;
  eclipse_direction = reflected;
#endif
  Scattered mirror = sky(above, mu_s, dot(reflected, sun));
  vec3 light = fresnel(mu) * mirror.radiance;
#ifdef HAS_MULTIPLE
  // All further orders by the source at the water: near the ground it changes slowly along a path.
  vec3 source = multiple_radiance(0.0, mu_s, above, dot(reflected, sun));
  light += fresnel(mu) * left * source * (1.0 - mirror.transmittance);
#endif
  return light + level_light * glint(mu, max(mu_s, 0.01), dot(to_eye, sun));
}
#endif

// Radiance [1/sr] that the ground sends to the eye, before the air between. up = unit direction of the point, to_eye =
// unit vector, distance [m] to the eye.
vec3 ground_radiance(vec3 up, vec3 to_eye, float distance) {
  float slant = max(dot(up, to_eye), 0.0);
  vec3 sun = -u_shadow_axis.direction;
  vec2 uv = map_coordinates(up);
  vec3 albedo = u_ground_albedo;
#ifdef HAS_COLOR_MAP
  albedo = smooth_map(u_color_map, uv, map_level(u_color_map, distance, slant)).rgb;
#endif
  vec3 normal = up;
  float altitude = 0.0;
#ifdef HAS_RELIEF
  vec4 relief = smooth_map(u_relief_map, uv, map_level(u_relief_map, distance, slant));
  vec3 east = normalize(vec3(-up.y, up.x, 0.0) + vec3(0.0, 1.0e-9, 0.0));
  normal = normalize(up - relief.x * east - relief.y * cross(up, east));
  altitude = max(relief.z, 0.0);
#endif
  // The terrain stands above the terminator plane's shadow edge by its altitude; its slope decides the rest.
  float height = dot(up, sun) * (u_bottom_radius + altitude);
  float k = altitude * (2.0 * u_bottom_radius + altitude);
#ifdef HAS_TERMINATOR
  // A strip of the disc that stands higher by an angle is turned toward the vertical by it.
  float mu_s = dot(up, sun);
  float upward = (dot(normal, up) - mu_s * dot(normal, sun)) * inversesqrt(max(1.0 - mu_s * mu_s, 1.0e-6));
  vec3 light = disc_irradiance(k, height, dot(normal, sun), upward);
  vec3 level_light = light;  // the sea is level
#else
  bool hidden = height < 0.0 && k < height * height;
  vec3 sunlight = hidden ? vec3(0.0) : transmittance_to_top(k, height);
  vec3 light = sunlight * max(dot(normal, sun), 0.0);
  vec3 level_light = sunlight * max(dot(up, sun), 0.0);
#endif
#ifdef HAS_ECLIPSE
  float visible = sun_visibility(up * (u_bottom_radius + altitude));
#ifdef HAS_TERMINATOR_MOONS
  vec3 at = up * (u_bottom_radius + altitude) * u_sun_axes;
  vec3 passing = disc_visibility(at, visible, k, height, vec2(dot(normal, sun), upward));
  light *= passing;
  level_light *= passing;
#else
  light *= visible;
  level_light *= visible;
#endif
#endif
  vec3 left = vec3(1.0);  // of skylight
#ifdef HAS_RATIO
  left = ground_ratio(up);
#else
#ifdef HAS_ECLIPSE
  left = vec3(visible);
#endif
#endif
#ifdef HAS_MULTIPLE
  // A slope sees the part of the sky above it; its light is taken as even over the sky.
  light += 0.5 * (1.0 + dot(normal, up)) * left * ground_irradiance(dot(up, sun));
#endif
  vec3 radiance = albedo / PI * light;
#ifdef HAS_WATER
  // By the share, since smoothed altitudes reach out into the sea: an islet would shade two hundred kilometers of it.
  float sea = smoothstep(0.25, 0.75, relief.w);
  radiance += sea * mirrored(up, to_eye, sun, level_light, left);
#endif
  return u_irradiance * radiance;
}
