#version 330 core
// Skylight on a horizontal surface by one order of scattering, over the sun's height (across) and altitude (up).

#include "table_directions.glsl"
#include "table_source.glsl"

uniform vec2 u_irradiance_size;

out vec4 out_irradiance;

void main() {
  vec2 unit = (gl_FragCoord.xy - 0.5) / max(u_irradiance_size - 1.0, 1.0);
  float altitude = unit.y * u_thickness;
  float k = altitude * (2.0 * u_bottom_radius + altitude);
  float r = u_bottom_radius + altitude;
  float mu_s = sun_of_axis(unit.x);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < UP_COUNT; ++i) {
    vec2 direction = gathered_direction(i, 0.0);
    float mu = direction.x;
    for (int j = 0; j < AROUND; ++j) {
      float nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * COSINES[j];
      TableCell cell = inscatter_at(k, r * mu, vec2(r * mu_s, nu), k - r * mu * r * mu, false);
#ifdef HAS_FIRST_ORDER
#ifdef HAS_AD_HOC_PHASE
      float molecules = ad_hoc_phase(nu);
#else
      float molecules = rayleigh_phase(nu);
#endif
      vec3 radiance = stored_radiance(cell, molecules, mie_phase(nu, max(1.0 - nu * nu, 0.0)));
#else
      vec3 radiance = stored_radiance(cell);
#endif
      sum += direction.y * mu * radiance;
    }
  }
  out_irradiance = vec4(sum, 1.0);
}
