// Single scattering by uniform steps over the whole path, the usual practice.
//
// A step stands for its middle: its density there, the columns behind it plus half its own, and the sun's columns from the
// table. It is dark where its middle lies in the planet's shadow, so that the shadow's edge is known to half a step only.

#ifdef HAS_ECLIPSE
#include "eclipse.glsl"
#endif
#include "phase.glsl"
#include "transmittance.glsl"

struct Scattered {
  vec3 transmittance;
  vec3 radiance;  // 1/sr, per unit irradiance
#ifdef HAS_ECLIPSE
  float visibility;  // of the sun from where the light comes from
#endif
};

// The whole path of a ray. `sun` = height of the base point above the terminator plane [m] and its derivative along the ray;
// cuts [m]: near end, where the shadow begins and ends, far end.
Scattered scatter(Ray ray, vec2 sun, float across, vec4 cuts) {
  float length = (cuts.w - cuts.x) / float(STEPS);
  vec3 columns = vec3(0.0);
  vec3 rayleigh = vec3(0.0);
  vec3 mie = vec3(0.0);
#ifdef HAS_OZONE
  vec3 crossings = ozone_crossings(ray.tangent_k);
  float ozone_start = ozone_to(ray.tangent_k, crossings, ray.x);
#endif
#ifdef HAS_ECLIPSE
  vec2 light_sum = vec2(0.0);
#endif
  for (int i = 0; i < STEPS; ++i) {
    float t = cuts.x + (float(i) + 0.5) * length;
    float k = k_along(ray, t);
    vec2 amount = length * densities(altitude_of(k));
    columns.xy += 0.5 * amount;
#ifdef HAS_OZONE
    columns.z = ozone_to(ray.tangent_k, crossings, ray.x + t) - ozone_start;
#endif
    vec3 light = exp(-optical_depth(columns + columns_to_top(k, sun.x + sun.y * t)));
    columns.xy += 0.5 * amount;
#ifdef HAS_SHADOW
    light *= t > cuts.y && t < cuts.z ? 0.0 : 1.0;
#endif
#ifdef HAS_ECLIPSE
    float visible = visibility_along(t);
    light_sum += vec2(visible, 1.0) * light.y * (amount.x + amount.y);
    light *= visible;
#endif
    rayleigh += light * amount.x;
    mie += light * amount.y;
  }
#ifdef HAS_OZONE
  columns.z = ozone_to(ray.tangent_k, crossings, ray.x + cuts.w) - ozone_start;
#endif
  Scattered air;
  air.transmittance = exp(-optical_depth(columns));
  air.radiance = rayleigh_phase(sun.y) * u_rayleigh_scattering * rayleigh + mie_phase(sun.y, across) * u_mie_scattering * mie;
#ifdef HAS_ECLIPSE
  air.visibility = light_sum.y > 0.0 ? light_sum.x / light_sum.y : 1.0;
#endif
  return air;
}
