#version 330 core
// Irradiance of the ground by singly scattered skylight, over the sun's height: one texel per height, a sum over the sky.

#include "sky.glsl"
#include "sky_irradiance.glsl"

const float SKY_NODES[SKY_COUNT] = SKY_NODE_VALUES;
const float SKY_WEIGHTS[SKY_COUNT] = SKY_WEIGHT_VALUES;

out vec4 out_irradiance;

void main() {
  float mu_s = irradiance_sun_height(gl_FragCoord.x);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < SKY_COUNT; ++i) {
    float mu = SKY_NODES[i] * SKY_NODES[i];  // crowds the nodes at the horizon, where a low sun's light is
    for (int j = 0; j < AZIMUTHS; ++j) {
      float azimuth = PI * (float(j) + 0.5) / float(AZIMUTHS);
      float weight = SKY_WEIGHTS[i] * 2.0 * SKY_NODES[i] * mu * 2.0 * PI / float(AZIMUTHS);
      float nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * cos(azimuth);
      sum += weight * sky(mu, mu_s, nu).radiance;
    }
  }
  out_irradiance = vec4(sum, 1.0);
}
