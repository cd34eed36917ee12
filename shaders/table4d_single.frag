#version 330 core
// Precompute the 4D table, step 1: single scattering of every texel, molecules and aerosols apart, phases left out.

#include "segments.glsl"
#include "table_shadow.glsl"

layout(location = 0) out vec4 out_rayleigh;
layout(location = 1) out vec4 out_mie;

void main() {
  TablePath path = inscatter_texel(ivec2(gl_FragCoord.xy));
  vec4 cuts = shadow_cuts(path);
  Inscatter sum = no_inscatter();
  if (cuts.y > cuts.x) add_lit(path.ray, path.sun, cuts.x, cuts.y, sum);
  if (cuts.z > cuts.y) pass_gap(path.ray, cuts.y, cuts.z, sum);
  if (cuts.w > cuts.z) add_lit(path.ray, path.sun, cuts.z, cuts.w, sum);
  out_rayleigh = vec4(u_rayleigh_scattering * sum.rayleigh, 1.0);
  out_mie = vec4(u_mie_scattering * sum.mie, 1.0);
}
