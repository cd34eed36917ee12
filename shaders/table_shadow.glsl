// Where the planet's shadow cuts the path of a table's texel.

#include "shadow.glsl"
#include "table_path.glsl"

uniform Cone u_shadow;  // the planet's, for the parallel sun

// Cuts [m] as the widths pass has them: near end, where the shadow begins and ends, far end.
vec4 shadow_cuts(TablePath path) {
  Ray ray = path.ray;
  float z = -path.sun.x;
  float nu = path.sun.y;
  float across = max(1.0 - nu * nu, 0.0);
  float drift = ray.x + z * nu;
  float r = u_bottom_radius + altitude_of(ray.k);
  float impact = safe_sqrt(across * (r - z) * (r + z) - drift * drift);
  vec2 shadow = cone_interval(AxisRay(z, -nu, across, drift, impact, ray.k - z * z), u_shadow, 1.0);
  float from = clamp(shadow.x, 0.0, path.end);
  return vec4(0.0, from, clamp(shadow.y, from, path.end), path.end);
}
