// The moments of one order's radiance field, or of all orders with a geometric tail for those that were not gathered.

uniform sampler2D u_moments;  // across: the order, inside it the coefficient; up: altitude, inside it the sun
uniform int u_first_column;   // of the one order

const float DARK = 1.0e-30;

vec3 field_moment(int coefficient, int row) {
#ifdef HAS_SUM
  int lead = coefficient == COEFFICIENTS - 1 ? coefficient : 0;  // the irradiance has a ratio of its own
  vec3 sum = vec3(0.0);
  for (int i = 0; i < ORDERS; ++i) sum += texelFetch(u_moments, ivec2(i * COEFFICIENTS + coefficient, row), 0).rgb;
  vec3 last = texelFetch(u_moments, ivec2((ORDERS - 1) * COEFFICIENTS + lead, row), 0).rgb;
  vec3 before = texelFetch(u_moments, ivec2((ORDERS - 2) * COEFFICIENTS + lead, row), 0).rgb;
  vec3 ratio = clamp(last / max(before, DARK), 0.0, 0.95);
  return sum + ratio / (1.0 - ratio) * texelFetch(u_moments, ivec2((ORDERS - 1) * COEFFICIENTS + coefficient, row), 0).rgb;
#else
  return texelFetch(u_moments, ivec2(u_first_column + coefficient, row), 0).rgb;
#endif
}
