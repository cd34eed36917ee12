#version 330 core
// Solve, step 4 too: logarithm of the mean radiance (altitude up, sun across), or of the ground's irradiance (one row), at
// MULTIPLE_FINER places to a cell by monotone cubics: straight lines between the nodes would show as bands in twilight.

#include "multiple_field.glsl"

uniform int u_coefficient;
uniform float u_scale;

out vec4 out_level;

vec3 node_level(int row, int sun) {
  return log(max(u_scale * field_moment(u_coefficient, row * MULTIPLE_SUNS + clamp(sun, 0, MULTIPLE_SUNS - 1)), DARK));
}

// Slope at a node: the harmonic mean of those beside it (Fritsch and Butland 1984), or 0 at an extremum.
vec3 node_slope(vec3 before, vec3 after) {
  vec3 product = before * after;
  return mix(vec3(0.0), 2.0 * product / mix(vec3(1.0), before + after, greaterThan(product, vec3(0.0))),
             greaterThan(product, vec3(0.0)));
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int cell = min(texel.x / MULTIPLE_FINER, MULTIPLE_SUNS - 2);
  float f = float(texel.x - cell * MULTIPLE_FINER) / float(MULTIPLE_FINER);
  vec3 low = node_level(texel.y, cell);
  vec3 high = node_level(texel.y, cell + 1);
  vec3 step = high - low;
  vec3 before = cell == 0 ? step : low - node_level(texel.y, cell - 1);
  vec3 after = cell == MULTIPLE_SUNS - 2 ? step : node_level(texel.y, cell + 2) - high;
  vec3 start = node_slope(before, step);
  vec3 end = node_slope(step, after);
  out_level = vec4(low + f * (start + f * (3.0 * step - 2.0 * start - end + f * (start + end - 2.0 * step))), 1.0);
}
