#version 330 core
// Precompute, last step: both species and all orders in one texture, as Bruneton and Neyret 2008, section 4, pack them.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_rayleigh;
uniform sampler2D u_mie;
uniform sampler2D u_multiple;

out vec4 out_stored;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  // Higher orders are divided by the molecules' phase function, which each pixel multiplies back.
  float phase = rayleigh_phase(inscatter_texel(texel).sun.y);
  vec3 molecules = texelFetch(u_rayleigh, texel, 0).rgb + texelFetch(u_multiple, texel, 0).rgb / phase;
  out_stored = vec4(molecules, texelFetch(u_mie, texel, 0).r);
}
