// Directions in which a point of a table gathers light: Gauss nodes, squared away from the horizon where light jumps, and
// midpoints in azimuth over half a turn, which stand for the other half too.

#include "phase.glsl"

const float UP_NODES[UP_COUNT] = UP_NODE_VALUES;
const float UP_WEIGHTS[UP_COUNT] = UP_WEIGHT_VALUES;
const float DOWN_NODES[DOWN_COUNT] = DOWN_NODE_VALUES;
const float DOWN_WEIGHTS[DOWN_COUNT] = DOWN_WEIGHT_VALUES;
const float COSINES[AROUND] = COSINE_VALUES;
const float SINES[AROUND] = SINE_VALUES;

uniform float u_band[BAND_COUNT];  // the aerosols' phase function as a polynomial, low powers first

// Zenith cosine and weight [sr] of a direction; those below the horizon come last.
vec2 gathered_direction(int polar, float horizon) {
  bool up = polar < UP_COUNT;
  int below = max(polar - UP_COUNT, 0);
  float node = up ? UP_NODES[min(polar, UP_COUNT - 1)] : DOWN_NODES[below];
  float weight = up ? UP_WEIGHTS[min(polar, UP_COUNT - 1)] : DOWN_WEIGHTS[below];
  float range = up ? 1.0 - horizon : 1.0 + horizon;
  float offset = range * node * node;
  return vec2(up ? horizon + offset : horizon - offset, weight * range * 2.0 * node * 2.0 * PI / float(AROUND));
}

// The aerosols' phase function without the degrees that the directions cannot resolve.
float band_phase(float nu) {
  float sum = u_band[BAND_COUNT - 1];
  for (int i = BAND_COUNT - 2; i >= 0; --i) sum = u_band[i] + nu * sum;
  return sum;
}
