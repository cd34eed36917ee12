// What the shadows of moons and rings do along a ray.

#include "visibility.glsl"

vec3 eclipse_base;       // m, base point of the ray whose points are asked for; set by the caller
vec3 eclipse_direction;

// The rotation of base and direction is the same for all points of a ray, and compilers see it.
float visibility_along(float t) { return visibility_at(eclipse_base * u_sun_axes + t * (eclipse_direction * u_sun_axes)); }

// Light that was scattered before fades with the sun too, and in totality a thousandth comes in from the penumbra: the
// order of it, no more.
float diffuse_visibility(float visible) { return (visible + 0.001) / 1.001; }
