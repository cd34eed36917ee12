#version 330 core
// Sunlight for a host's own shaders: what moons, rings and the planet leave of the sun at a planet-centered point.

#include "sunlit.glsl"

uniform vec4 u_planet;  // unit vector to the sun, radius of the planet [m]

// Fraction of the sun that is to be seen from a point [m].
float visible_sun(vec3 point) {
  float y = dot(point, u_planet.xyz);
  vec3 across = cross(point, u_planet.xyz);
  float radius = length(point);
  bool shadowed = y < 0.0 && dot(across, across) < u_planet.w * u_planet.w;
  return visible_sun(point, (radius - u_planet.w) * (radius + u_planet.w), y, shadowed);
}
