#version 330 core
// What a table of inscatter says of one ray per fragment, for one sun: light of the air, and skylight off the ground.

#ifdef HAS_TABLE3D
#include "table3d.glsl"
#endif
#ifdef HAS_TABLE4D
#include "table4d.glsl"
#endif
#ifdef HAS_ECLIPSE
#include "table_eclipse.glsl"
#endif
#include "shadow.glsl"
#include "table_sky.glsl"

uniform sampler2D u_ray;     // x, k, tangent_k, air
uniform sampler2D u_axis;    // z, dz, across, drift
uniform sampler2D u_limits;  // impact, rim, t_max from the base point
#ifdef HAS_ECLIPSE
uniform sampler2D u_base;  // m, planet-centered base point
uniform sampler2D u_direction;
#endif
uniform vec3 u_ground_albedo;
uniform Cone u_shadow;  // the planet's, for the parallel sun

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_ground;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 a = texelFetch(u_ray, texel, 0);
  vec4 b = texelFetch(u_axis, texel, 0);
  vec4 c = texelFetch(u_limits, texel, 0);
  Ray ray = Ray(a.x, a.y, a.z, 0.0, a.w);
  out_radiance = vec4(0.0);
  out_ground = vec4(0.0);
  if (ray.air < 0.0) return;

  float ground = ground_distance(ray);
  float end = ground >= 0.0 ? min(ground, ray.air) : ray.air;
  bool hits = ground >= 0.0 && c.z >= end;
  end = clamp(c.z, 0.0, end);
  vec2 shadow = cone_interval(AxisRay(b.x, b.y, b.z, b.w, c.x, c.y), u_shadow, 1.0);
  float from = clamp(shadow.x, 0.0, end);
  vec2 sun = vec2(-b.x, -b.y);
  vec4 cuts = vec4(0.0, from, clamp(shadow.y, from, end), end);
  Scattered air = scatter(ray, sun, b.z, cuts);
  vec3 skylight = table_sky_irradiance((sun.x + sun.y * end) / u_bottom_radius);
#ifdef HAS_ECLIPSE
  eclipse_base = texelFetch(u_base, texel, 0).xyz;
  eclipse_direction = texelFetch(u_direction, texel, 0).xyz;
  air.radiance *= path_visibility(ray, sun, cuts);
  skylight *= visibility_along(end);
#endif
  out_radiance = vec4(air.radiance, 1.0);
  out_ground = vec4(hits ? air.transmittance * u_ground_albedo / PI * skylight : vec3(0.0), 1.0);
}
