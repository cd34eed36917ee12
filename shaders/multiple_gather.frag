#version 330 core
// Solve, step 1: radiance of one order in the gathered directions (across) at the nodes of the table (up).

#include "multiple_path.glsl"
#include "shadow.glsl"

uniform Cone u_shadow;           // the planet's, for the parallel sun
uniform sampler2D u_directions;  // mu of the gathered directions, by altitude
uniform vec3 u_ground_albedo;
#ifndef HAS_MULTIPLE
uniform float u_band[BAND_COUNT];  // Legendre series of the aerosols' phase function

float band_phase(float nu) {
  float before = 1.0;
  float current = nu;
  float sum = u_band[0];
  for (int l = 1; l < BAND_COUNT; ++l) {
    sum += u_band[l] * current;
    float after = (float(2 * l + 1) * nu * current - float(l) * before) / float(l + 1);
    before = current;
    current = after;
  }
  return sum;
}
#endif

out vec4 out_radiance;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int height = texel.y / MULTIPLE_SUNS;
  float altitude = height_of(float(height) / float(MULTIPLE_HEIGHTS - 1));
  float mu_s = sun_height(float(texel.y % MULTIPLE_SUNS) / float(MULTIPLE_SUNS - 1));
  float mu = texelFetch(u_directions, ivec2(texel.x / AROUND, height), 0).x;
  float azimuth = PI * (float(texel.x % AROUND) + 0.5) / float(AROUND);
  float nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * cos(azimuth);

  float r = u_bottom_radius + altitude;
  float k = min(altitude * (2.0 * u_bottom_radius + altitude), u_top_k);
  Ray ray = make_ray(r * mu, k, k - r * mu * r * mu);
  float z = -r * mu_s;
  float across = max(1.0 - nu * nu, 0.0);
  float drift = r * mu + z * nu;
  float impact = safe_sqrt(across * (r * r - z * z) - drift * drift);
  vec2 shadow = cone_interval(AxisRay(z, -nu, across, drift, impact, k - z * z), u_shadow, 1.0);
  float ground = ground_distance(ray);
  float end = ground >= 0.0 ? ground : max(ray.air, 0.0);
  float from = clamp(shadow.x, 0.0, end);
  vec4 cuts = vec4(0.0, from, clamp(shadow.y, from, end), end);
  vec2 sun = vec2(-z, nu);
  float ground_sun = (sun.x + sun.y * end) / u_bottom_radius;

#ifdef HAS_MULTIPLE
  Gathered sum = gather(ray, sun, cuts, vec3(0.0));
  vec3 radiance = sum.radiance;
  vec3 transmittance = clearness(ray, sum.columns, end);
  vec3 irradiance = ground_irradiance(ground_sun);
#else
  Inscatter sum = no_inscatter();
  if (cuts.y > cuts.x) add_lit(ray, sun, cuts.x, cuts.y, sum);
  if (cuts.z > cuts.y) pass_gap(ray, cuts.y, cuts.z, sum);
  if (cuts.w > cuts.z) add_lit(ray, sun, cuts.z, cuts.w, sum);
  finish_columns(ray, end, sum);
  vec3 radiance = rayleigh_phase(nu) * u_rayleigh_scattering * sum.rayleigh + band_phase(nu) * u_mie_scattering * sum.mie;
  vec3 transmittance = exp(-optical_depth(sum.columns));
  float lit = max(ground_sun, 0.0);
  vec3 irradiance = lit * transmittance_to_top(0.0, lit * u_bottom_radius);
#endif
  vec3 reflected = transmittance * u_ground_albedo / PI * irradiance;
  out_radiance = vec4(radiance + (ground >= 0.0 ? reflected : vec3(0.0)), 1.0);
}
