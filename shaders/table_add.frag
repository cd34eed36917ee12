#version 330 core
// Precompute: one order more into the sum of all, by blending.

uniform sampler2D u_rayleigh;
uniform float u_scale;
layout(location = 0) out vec4 out_rayleigh;
#ifdef HAS_SPECIES
uniform sampler2D u_mie;
layout(location = 1) out vec4 out_mie;
#endif

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  out_rayleigh = u_scale * texelFetch(u_rayleigh, texel, 0);
#ifdef HAS_SPECIES
  out_mie = u_scale * texelFetch(u_mie, texel, 0);
#endif
}
