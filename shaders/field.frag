#version 330 core
// One field of the cuts (widths.frag) as a texture of its own, for those who ask for it.

uniform sampler2D u_cuts;
uniform vec4 u_weights;

out float out_field;

void main() {
  vec4 cuts = texelFetch(u_cuts, ivec2(gl_FragCoord.xy), 0);
  // inf times a weight of 0 would be nan, so the distance is taken apart
  out_field = u_weights.x > 0.0 ? cuts.x : dot(u_weights.yzw, cuts.yzw);
}
