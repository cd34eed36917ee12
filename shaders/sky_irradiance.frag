#version 330 core
// Irradiance of the ground by singly scattered skylight, over the sun's height: one texel per height, a sum over the sky.

#include "segments.glsl"
#include "shadow.glsl"
#include "sky_irradiance.glsl"

uniform Cone u_shadow;  // the planet's, for the parallel sun

const float SKY_NODES[SKY_COUNT] = SKY_NODE_VALUES;
const float SKY_WEIGHTS[SKY_COUNT] = SKY_WEIGHT_VALUES;

out vec4 out_irradiance;

// A ray from the ground at zenith cosine mu, seen from the sun's axis; the point stands on the sun's meridian.
Scattered sky_ray(float mu, float mu_s, float azimuth) {
  float nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * cos(azimuth);
  Ray ray = make_ray(u_bottom_radius * mu, 0.0, -u_bottom_radius * u_bottom_radius * mu * mu);
  float z = -u_bottom_radius * mu_s;
  float across = max(1.0 - nu * nu, 0.0);
  float drift = ray.x + z * nu;
  float impact = safe_sqrt(across * u_bottom_radius * u_bottom_radius * (1.0 - mu_s * mu_s) - drift * drift);
  AxisRay axis = AxisRay(z, -nu, across, drift, impact, -z * z);
  vec2 shadow = cone_interval(axis, u_shadow, 1.0);
  float from = clamp(shadow.x, 0.0, ray.air);
  return scatter(ray, vec2(-z, nu), across, vec4(0.0, from, clamp(shadow.y, from, ray.air), ray.air));
}

void main() {
  float mu_s = irradiance_sun_height(gl_FragCoord.x);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < SKY_COUNT; ++i) {
    float mu = SKY_NODES[i] * SKY_NODES[i];  // crowds the nodes at the horizon, where a low sun's light is
    for (int j = 0; j < AZIMUTHS; ++j) {
      float azimuth = PI * (float(j) + 0.5) / float(AZIMUTHS);
      float weight = SKY_WEIGHTS[i] * 2.0 * SKY_NODES[i] * mu * 2.0 * PI / float(AZIMUTHS);
      sum += weight * sky_ray(mu, mu_s, azimuth).radiance;
    }
  }
  out_irradiance = vec4(sum, 1.0);
}
