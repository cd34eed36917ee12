// Radiance of one order of scattering from the table that is being made.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_rayleigh;
uniform sampler2D u_mie;

#ifdef HAS_FIRST_ORDER
// Radiance of singly scattered light, given the phases of molecules and aerosols.
vec3 stored_radiance(TableCell cell, float rayleigh, float mie) {
  return rayleigh * inscatter_fetch(u_rayleigh, cell).rgb + mie * inscatter_fetch(u_mie, cell).rgb;
}
#else
// Radiance of a later order, whose phases are in it.
vec3 stored_radiance(TableCell cell) {
#ifdef HAS_SPECIES
  return inscatter_fetch(u_rayleigh, cell).rgb + inscatter_fetch(u_mie, cell).rgb;
#else
  return inscatter_fetch(u_rayleigh, cell).rgb;
#endif
}
#endif
