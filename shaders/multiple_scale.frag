#version 330 core
// Solve, step 4: coefficients over the mean radiance, times the mixture's phase moments: those of the source.

#include "multiple_field.glsl"

uniform sampler2D u_mixture;  // phase moments of the mixture; across: the coefficient, up: altitude

const float MEAN = 0.282094791773878;  // radiance of the zeroth harmonic

out vec4 out_moment;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 mean = max(MEAN * field_moment(0, texel.y), DARK);
  vec3 mixture = texelFetch(u_mixture, ivec2(texel.x, texel.y / MULTIPLE_SUNS), 0).rgb;
  out_moment = vec4(mixture * field_moment(texel.x, texel.y) / mean, 1.0);
}
