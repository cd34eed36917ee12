// What the shadows of moons and rings do along a ray.

#include "visibility.glsl"

vec3 eclipse_base;       // m, base point of the ray whose points are asked for; set by the caller
vec3 eclipse_direction;

// The rotation of base and direction is the same for all points of a ray, and compilers see it.
float visibility_along(float t) { return visibility_at(eclipse_base * u_sun_axes + t * (eclipse_direction * u_sun_axes)); }

#ifdef HAS_MOON_TABLES
// Fraction of the sun's light that one moon alone leaves at a planet-centered point [m]; narrow moons come first.
float visible_fraction(vec3 point, int index) {
  vec3 p = point * u_sun_axes;
#ifdef HAS_NARROW_MOONS
  if (index < NARROW_MOONS) return narrow_fraction(p, index);
  index -= NARROW_MOONS;
#endif
#ifdef HAS_WIDE_MOONS
  return wide_fraction(p, index);
#else
  return 1.0;
#endif
}
#endif
