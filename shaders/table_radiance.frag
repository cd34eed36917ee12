#version 330 core
// Precompute, step 2: radiance of one order in the gathered directions (across) at heights and suns of the table (up).

#include "table_directions.glsl"
#include "table_source.glsl"

#ifdef HAS_GROUND
uniform vec3 u_ground_albedo;
#ifndef HAS_FIRST_ORDER
#include "table_sky.glsl"
#endif
#endif

out vec4 out_radiance;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int height = texel.y / INSCATTER_SUNS;
  float k = altitude_axis_k(float(height) / float(INSCATTER_HEIGHTS - 1));
  float mu_s = sun_of_axis(float(texel.y - height * INSCATTER_SUNS) / float(INSCATTER_SUNS - 1));
  float r = u_bottom_radius + altitude_of(k);
  int polar = texel.x / AROUND;
  float mu = gathered_direction(polar, -safe_sqrt(k) / r).x;
  float nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * COSINES[texel.x - polar * AROUND];
  float x = r * mu;
  bool ground = polar >= UP_COUNT;
  float tangent_k = ground ? min(k - x * x, 0.0) : k - x * x;
  vec2 sun = vec2(r * mu_s, nu);
  TableCell cell = inscatter_at(k, x, sun, tangent_k, ground);
#ifdef HAS_FIRST_ORDER
  vec3 radiance = stored_radiance(cell, rayleigh_phase(nu), band_phase(nu));
#else
  vec3 radiance = stored_radiance(cell);
#endif
#ifdef HAS_GROUND
  float distance = k / (safe_sqrt(-tangent_k) - x);
  Ray ray = Ray(x, k, tangent_k, 0.0, distance);
  float ground_sun = (sun.x + nu * distance) / u_bottom_radius;
#ifdef HAS_FIRST_ORDER
  float lit = max(ground_sun, 0.0);
  vec3 irradiance = lit * transmittance_to_top(0.0, lit * u_bottom_radius);
#else
  vec3 irradiance = table_sky_irradiance(ground_sun);  // by the order before
#endif
  vec3 clear = clearness(columns_beyond(ray, 0.0), columns_beyond(ray, distance));
  radiance += ground ? clear * u_ground_albedo / PI * irradiance : vec3(0.0);
#endif
  out_radiance = vec4(radiance, 1.0);
}
