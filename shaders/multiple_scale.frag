#version 330 core
// Solve, step 4: coefficients over the mean radiance, times the phase moments of aerosols: those of the source, at the
// altitudes of the table.

#include "multiple_field.glsl"

uniform sampler2D u_phase_moments;  // across: the coefficient
uniform float u_layer_step;         // between the table's altitudes, in steps of the field's

const float MEAN = 0.282094791773878;  // radiance of the zeroth harmonic

out vec4 out_moment;

vec3 shape(int coefficient, int row) {
  return field_moment(coefficient, row) / max(MEAN * field_moment(0, row), DARK);
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int layer = texel.y / MULTIPLE_SUNS;
  float place = float(layer) * u_layer_step;
  int height = min(int(place), MULTIPLE_HEIGHTS - 2);
  int row = height * MULTIPLE_SUNS + texel.y - layer * MULTIPLE_SUNS;
  vec3 between = mix(shape(texel.x, row), shape(texel.x, row + MULTIPLE_SUNS), place - float(height));
  out_moment = vec4(texelFetch(u_phase_moments, ivec2(texel.x, 0), 0).x * between, 1.0);
}
