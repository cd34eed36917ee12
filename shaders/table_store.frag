#version 330 core
// Precompute, last step: both species in one texture, as Bruneton and Neyret 2008, section 4, pack them; and with
// HAS_COMBINED all orders.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_rayleigh;
uniform sampler2D u_mie;
#ifdef HAS_COMBINED
uniform sampler2D u_multiple;
#endif

out vec4 out_stored;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 molecules = texelFetch(u_rayleigh, texel, 0).rgb;
#ifdef HAS_COMBINED
  // Higher orders are divided by the molecules' phase function, which each pixel multiplies back.
  molecules += texelFetch(u_multiple, texel, 0).rgb / rayleigh_phase(inscatter_texel(texel).sun.y);
#endif
  out_stored = vec4(molecules, texelFetch(u_mie, texel, 0).r);
}
