// The moments of one order's radiance field, or of all orders with a geometric tail for those that were not gathered.

uniform sampler2D u_moments;  // across: the coefficient; up: the order, inside it altitude, inside it the sun
uniform int u_first_row;      // of the one order

const int ROWS = MULTIPLE_HEIGHTS * MULTIPLE_SUNS;
const float DARK = 1.0e-30;

vec3 field_moment(int coefficient, int row) {
#ifdef HAS_SUM
  int lead = coefficient == COEFFICIENTS - 1 ? coefficient : 0;  // the irradiance has a ratio of its own
  vec3 sum = vec3(0.0);
  for (int i = 0; i < ORDERS; ++i) sum += texelFetch(u_moments, ivec2(coefficient, i * ROWS + row), 0).rgb;
  vec3 last = texelFetch(u_moments, ivec2(lead, (ORDERS - 1) * ROWS + row), 0).rgb;
  vec3 before = texelFetch(u_moments, ivec2(lead, (ORDERS - 2) * ROWS + row), 0).rgb;
  vec3 ratio = clamp(last / max(before, DARK), 0.0, 0.95);
  return sum + ratio / (1.0 - ratio) * texelFetch(u_moments, ivec2(coefficient, (ORDERS - 1) * ROWS + row), 0).rgb;
#else
  return texelFetch(u_moments, ivec2(coefficient, u_first_row + row), 0).rgb;
#endif
}
