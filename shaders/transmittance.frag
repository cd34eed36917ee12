#version 330 core
// The table of columns from a point to the top of the air: x molecules, y aerosols, z ozone (see transmittance.glsl).

#include "transmittance.glsl"

const float NODES[NODE_COUNT] = NODE_VALUES;
const float WEIGHTS[NODE_COUNT] = WEIGHT_VALUES;

out vec4 out_columns;

// Columns of the two exponential layers between distances [m] from the tangent point, rising from a point of given k, by
// quadrature in a sinh map whose width follows the thinner layer.
vec2 integrate_layers(float k_start, float from, float to) {
  float r = u_bottom_radius + altitude_of(k_start);
  float scale = min(u_scale_height.x, u_scale_height.y);
  float slope = from / r;
  float width = scale * inversesqrt(slope * slope + 0.5 * scale / r);
  float span = log((to - from) / width + sqrt((to - from) * (to - from) / (width * width) + 1.0));
  vec2 columns = vec2(0.0);
  for (int i = 0; i < NODE_COUNT; ++i) {
    float e = exp(span * NODES[i]);
    float step = 0.5 * width * (e - 1.0 / e);
    float k = k_start + step * (step + 2.0 * from);
    columns += WEIGHTS[i] * 0.5 * width * span * (e + 1.0 / e) * densities(altitude_of(k));
  }
  return columns;
}

void main() {
  vec2 ky = table_point(gl_FragCoord.xy);
  float tangent_k = ky.x - ky.y * ky.y;
  float top = safe_sqrt(u_top_k - tangent_k);
  vec2 columns = integrate_layers(ky.x, abs(ky.y), max(top, abs(ky.y)));
  // A downward path first crosses its tangent point, and that part twice.
  if (ky.y < 0.0) columns += 2.0 * integrate_layers(tangent_k, 0.0, -ky.y);
  out_columns = vec4(columns, 0.0, 1.0);
#ifdef HAS_OZONE
  out_columns.z = ozone_to_top(ky.x, ky.y);
#endif
}
