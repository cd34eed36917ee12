// The sky as a point on the ground sees it.

#include "segments.glsl"
#include "shadow.glsl"

uniform Cone u_shadow;  // the planet's, for the parallel sun

// Light and transmittance of the sky in a direction at zenith cosine mu > 0, with the sun at mu_s and nu between the two.
Scattered sky(float mu, float mu_s, float nu) {
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
