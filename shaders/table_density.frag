#version 330 core
// Precompute, step 3: mean radiance at a texel, weighted by the phase function of the direction one looks in.

#include "table_directions.glsl"
#include "table_path.glsl"

uniform sampler2D u_radiance;

#ifdef HAS_SPECIES
layout(location = 0) out vec4 out_rayleigh;
layout(location = 1) out vec4 out_mie;
#else
out vec4 out_mixture;
#endif

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  TablePath path = inscatter_texel(texel);
  ivec3 index = inscatter_index(texel);
  int row = index.x * INSCATTER_SUNS + index.z;
  float altitude = altitude_of(path.ray.k);
  float r = u_bottom_radius + altitude;
  float mu = path.ray.x / r;
  float mu_s = path.sun.x / r;
  float sine = safe_sqrt(1.0 - mu * mu);
  float azimuth = (path.sun.y - mu * mu_s) / max(sine * safe_sqrt(1.0 - mu_s * mu_s), 1.0e-6);
  azimuth = clamp(azimuth, -1.0, 1.0);
  vec2 turn = sine * vec2(azimuth, safe_sqrt(1.0 - azimuth * azimuth));
  float horizon = -safe_sqrt(path.ray.k) / r;
  vec3 rayleigh = vec3(0.0);
  vec3 mie = vec3(0.0);
  for (int i = 0; i < UP_COUNT + DOWN_COUNT; ++i) {
    vec2 direction = gathered_direction(i, horizon);
    float along = mu * direction.x;
    vec2 across = turn * safe_sqrt(1.0 - direction.x * direction.x);
    vec3 ring_rayleigh = vec3(0.0);
    vec3 ring_mie = vec3(0.0);
    for (int j = 0; j < AROUND; ++j) {
      vec3 radiance = texelFetch(u_radiance, ivec2(i * AROUND + j, row), 0).rgb;
      float left = along + dot(across, vec2(COSINES[j], SINES[j]));
      float right = along + dot(across, vec2(COSINES[j], -SINES[j]));
      ring_rayleigh += (1.0 + 0.5 * (left * left + right * right)) * radiance;
      ring_mie += (band_phase(left) + band_phase(right)) * radiance;
    }
    rayleigh += direction.y * ring_rayleigh;
    mie += direction.y * ring_mie;
  }
  // a phase function of few degrees dips below zero where there is next to no light
  rayleigh = max(3.0 / (16.0 * PI) * rayleigh, 0.0);
  mie = max(0.5 * mie, 0.0);
#ifdef HAS_SPECIES
  out_rayleigh = vec4(rayleigh, 1.0);
  out_mie = vec4(mie, 1.0);
#else
  // Both species' coefficients fall with altitude alone, so one table holds their mixture, and interpolates smoothly.
  vec2 density = densities(altitude);
  vec3 molecules = density.x * u_rayleigh_scattering;
  vec3 aerosols = density.y * u_mie_scattering;
  out_mixture = vec4((molecules * rayleigh + aerosols * mie) / max(molecules + aerosols, 1.0e-30), 1.0);
#endif
}
