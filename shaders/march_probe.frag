#version 330 core
// Transmittance and single scattering of one ray per fragment by uniform steps, for one sun.

#include "march.glsl"
#include "shadow.glsl"

uniform sampler2D u_ray;     // x, k, tangent_k, air
uniform sampler2D u_axis;    // z, dz, across, drift
uniform sampler2D u_limits;  // impact, rim, t_max from the base point
uniform Cone u_shadow;       // the planet's, for the parallel sun
#ifdef HAS_ECLIPSE
uniform sampler2D u_base;  // m, planet-centered base point
uniform sampler2D u_direction;
#endif

layout(location = 0) out vec4 out_transmittance;
layout(location = 1) out vec4 out_single;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 a = texelFetch(u_ray, texel, 0);
  vec4 b = texelFetch(u_axis, texel, 0);
  vec4 c = texelFetch(u_limits, texel, 0);
  Ray ray = Ray(a.x, a.y, a.z, 0.0, a.w);
  out_transmittance = vec4(1.0);
  out_single = vec4(0.0);
  if (ray.air < 0.0) return;

  float ground = ground_distance(ray);
  float end = clamp(c.z, 0.0, ground >= 0.0 ? min(ground, ray.air) : ray.air);
  vec2 shadow = cone_interval(AxisRay(b.x, b.y, b.z, b.w, c.x, c.y), u_shadow, 1.0);
  float from = clamp(shadow.x, 0.0, end);
#ifdef HAS_ECLIPSE
  eclipse_base = texelFetch(u_base, texel, 0).xyz;
  eclipse_direction = texelFetch(u_direction, texel, 0).xyz;
#endif
  Scattered air = scatter(ray, vec2(-b.x, -b.y), b.z, vec4(0.0, from, clamp(shadow.y, from, end), end));
  out_transmittance = vec4(air.transmittance, 1.0);
  out_single = vec4(air.radiance, 1.0);
}
