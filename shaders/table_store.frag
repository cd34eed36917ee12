#version 330 core
// Precompute, last step: the table in the form that frames read.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_rayleigh;
#ifdef HAS_PACKED
uniform sampler2D u_mie;
uniform sampler2D u_multiple;
#endif
uniform float u_scale;

out vec4 out_stored;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 stored = texelFetch(u_rayleigh, texel, 0);
#ifdef HAS_PACKED
  // Higher orders are divided by the molecules' phase function, which each pixel multiplies back.
  float phase = rayleigh_phase(inscatter_texel(texel).sun.y);
  stored.rgb += texelFetch(u_multiple, texel, 0).rgb / phase;
  stored.a = texelFetch(u_mie, texel, 0).r;
#endif
  out_stored = u_scale * stored;
}
