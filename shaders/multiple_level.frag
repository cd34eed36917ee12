#version 330 core
// Solve, step 4 too: logarithm of the mean radiance and the coefficients of what molecules scatter (three parts one over the
// other, in each altitude up, sun across), or logarithm of the ground's irradiance (one row). At several places to a cell by
// monotone cubics: straight lines between the nodes would show as bands in twilight.

#include "multiple_field.glsl"

const float MEAN = 0.282094791773878;  // radiance of the zeroth harmonic
// A tenth, the phase moment of molecules, times the norm of the harmonics of degree 2.
const vec3 NORMS = vec3(0.0630783130505040, 0.109254843059208, 0.0546274215296039);

out vec4 out_level;

vec4 node(int part, int height, int sun) {
  int row = height * MULTIPLE_SUNS + clamp(sun, 0, MULTIPLE_SUNS - 1);
#ifdef HAS_GROUND
  return vec4(log(max(field_moment(COEFFICIENTS - 1, row), DARK)), 1.0);
#else
  vec3 mean = max(MEAN * field_moment(0, row), DARK);
  float last = NORMS.z * field_moment(2 * DEGREE + 1, row)[part] / mean[part];
  if (part == 0) return vec4(log(mean), last);
  return vec4((part == 1 ? NORMS.x * field_moment(2, row) : NORMS.y * field_moment(DEGREE + 2, row)) / mean, last);
#endif
}

// Slope at a node: the harmonic mean of those beside it (Fritsch and Butland 1984), or 0 at an extremum.
vec4 node_slope(vec4 before, vec4 after) {
  vec4 product = before * after;
  bvec4 same = greaterThan(product, vec4(0.0));
  return mix(vec4(0.0), 2.0 * product / mix(vec4(1.0), before + after, same), same);
}

// Between b and c, of four in a row; where there is none before or after, the slope is that of the cell.
vec4 cubic(vec4 a, vec4 b, vec4 c, vec4 d, bool is_first, bool is_last, float f) {
  vec4 step = c - b;
  vec4 start = node_slope(is_first ? step : b - a, step);
  vec4 end = node_slope(step, is_last ? step : d - c);
  return b + f * (start + f * (3.0 * step - 2.0 * start - end + f * (start + end - 2.0 * step)));
}

vec4 row_level(int part, int height, int column) {
  int cell = min(column / MULTIPLE_FINER, MULTIPLE_SUNS - 2);
  float f = float(column - cell * MULTIPLE_FINER) / float(MULTIPLE_FINER);
  return cubic(node(part, height, cell - 1), node(part, height, cell), node(part, height, cell + 1),
               node(part, height, cell + 2), cell == 0, cell == MULTIPLE_SUNS - 2, f);
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
#ifdef HAS_GROUND
  out_level = row_level(0, 0, texel.x);
#else
  const int rows = MULTIPLE_FINER_HEIGHTS * (MULTIPLE_HEIGHTS - 1) + 1;
  int part = texel.y / rows;
  int up = texel.y - part * rows;
  int cell = min(up / MULTIPLE_FINER_HEIGHTS, MULTIPLE_HEIGHTS - 2);
  float f = float(up - cell * MULTIPLE_FINER_HEIGHTS) / float(MULTIPLE_FINER_HEIGHTS);
  out_level = cubic(row_level(part, max(cell - 1, 0), texel.x), row_level(part, cell, texel.x),
                    row_level(part, cell + 1, texel.x), row_level(part, min(cell + 2, MULTIPLE_HEIGHTS - 1), texel.x),
                    cell == 0, cell == MULTIPLE_HEIGHTS - 2, f);
#endif
}
