#version 330 core
// Sunlight for a host's own shaders: what moons, rings and the planet leave of the sun at a planet-centered point.

#ifdef HAS_ECLIPSE
#include "visibility.glsl"
#endif

uniform vec4 u_planet;  // unit vector to the sun, radius of the planet [m]

// Fraction of the sun that is to be seen from a point [m]; the planet's own shadow is that of a parallel sun.
float visible_sun(vec3 point) {
  vec3 across = cross(point, u_planet.xyz);
  float open_sky = dot(point, u_planet.xyz) < 0.0 && dot(across, across) < u_planet.w * u_planet.w ? 0.0 : 1.0;
#ifdef HAS_ECLIPSE
  open_sky *= sun_visibility(point);
#endif
  return open_sky;
}
