#version 330 core
// Radiometry and lengths of one ray per fragment, for one sun: the libraries of the composite pass, rays instead of pixels.

#include "segments.glsl"
#include "phase.glsl"
#include "shadow.glsl"
#ifdef HAS_TERMINATOR
#include "night.glsl"
#endif
#ifdef HAS_MULTIPLE
#include "multiple_path.glsl"
#endif
#ifdef HAS_RATIO
#include "eclipse_multiple_path.glsl"
#endif

uniform sampler2D u_ray;      // x, k, tangent_k, air
uniform sampler2D u_axis;     // z, dz, across, drift
uniform sampler2D u_limits;   // impact, rim, t_max from the base point
uniform vec3 u_ground_albedo;
uniform Cone u_shadow;  // the planet's, for the parallel sun
#ifdef HAS_TERMINATOR
uniform Cone u_night;  // where the planet hides the whole disc
#endif
#ifdef HAS_ECLIPSE
uniform sampler2D u_base;       // m, planet-centered base point
uniform sampler2D u_direction;
#endif

layout(location = 0) out vec4 out_transmittance;  // a: t_end from the base point
layout(location = 1) out vec4 out_single;         // a: 0 miss, 1 top, 2 ground, 3 t_max
layout(location = 2) out vec4 out_ground;         // a: length in the planet's shadow
#ifdef HAS_MULTIPLE
layout(location = 3) out vec4 out_multiple;
layout(location = 4) out vec4 out_ground_multiple;
#endif

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 a = texelFetch(u_ray, texel, 0);
  vec4 b = texelFetch(u_axis, texel, 0);
  vec4 c = texelFetch(u_limits, texel, 0);
  Ray ray = Ray(a.x, a.y, a.z, 0.0, a.w);
  AxisRay axis = AxisRay(b.x, b.y, b.z, b.w, c.x, c.y);
  out_transmittance = vec4(1.0, 1.0, 1.0, 0.0);
  out_single = vec4(0.0);
  out_ground = vec4(0.0);
#ifdef HAS_MULTIPLE
  out_multiple = vec4(0.0);
  out_ground_multiple = vec4(0.0);
#endif
  if (ray.air < 0.0) return;

  float end = ray.air;
  float code = 1.0;
  float ground = ground_distance(ray);
  if (ground >= 0.0 && ground <= end) {
    end = ground;
    code = 2.0;
  }
  if (c.z < end) {
    end = max(c.z, 0.0);
    code = 3.0;
  }
  vec2 shadow = cone_interval(axis, u_shadow, 1.0);
  float from = clamp(shadow.x, 0.0, end);
  float to = clamp(shadow.y, from, end);

#ifdef HAS_ECLIPSE
  eclipse_base = texelFetch(u_base, texel, 0).xyz;
  eclipse_direction = texelFetch(u_direction, texel, 0).xyz;
#endif
  vec2 sun = vec2(-axis.z, -axis.dz);
  Inscatter sum = no_inscatter();
#ifdef HAS_TERMINATOR
  vec2 dark = night_or_dusk(cone_interval(axis, u_night, 1.0), shadow, end);
  dark.x = clamp(dark.x, 0.0, end);
  dark.y = clamp(dark.y, dark.x, end);
#else
  vec2 dark = vec2(from, to);
#endif
  add_lit(ray, sun, 0.0, dark.x, sum);
  pass_gap(ray, dark.x, dark.y, sum);
  add_lit(ray, sun, dark.y, end, sum);
  finish_columns(ray, end, sum);
  vec3 transmittance = exp(-optical_depth(sum.columns));
  out_transmittance = vec4(transmittance, end);
  out_single = vec4(apply_phases(sum, sun.y, axis.across), code);

  float height = sun.x + sun.y * end;
#ifdef HAS_TERMINATOR
  float cosine = height / u_bottom_radius;
  vec3 direct = u_ground_albedo / PI * disc_irradiance(0.0, height, cosine, safe_sqrt(1.0 - cosine * cosine));
#else
  vec3 direct = u_ground_albedo / PI * max(height, 0.0) / u_bottom_radius * transmittance_to_top(0.0, max(height, 0.0));
#endif
#ifdef HAS_ECLIPSE
#ifdef HAS_TERMINATOR_MOONS
  vec3 at = (eclipse_base + end * eclipse_direction) * u_sun_axes;
  vec2 incidence = vec2(cosine, safe_sqrt(1.0 - cosine * cosine));
  direct *= disc_visibility(at, visibility_at(at), 0.0, height, incidence);
#else
  direct *= visibility_along(end);
#endif
#endif
  out_ground = vec4(code == 2.0 ? transmittance * direct : vec3(0.0), to - from);
#ifdef HAS_MULTIPLE
  out_multiple.rgb = gather(ray, sun, vec4(0.0, from, to, end), aureole_kernel(sun.y)).radiance;
  if (code == 2.0) out_ground_multiple.rgb = transmittance * u_ground_albedo / PI * ground_irradiance(height / u_bottom_radius);
#ifdef HAS_RATIO
  Shaded shaded = gather_shaded(ray, sun, vec4(0.0, from, to, end), aureole_kernel(sun.y), -1);
  out_multiple.rgb *= shaded.with / max(shaded.without, 1.0e-30);
  if (code == 2.0) out_ground_multiple.rgb *= ground_ratio((eclipse_base + end * eclipse_direction) / u_bottom_radius);
#else
#ifdef HAS_ECLIPSE
  out_multiple.rgb *= mean_visibility(sum.light);
  out_ground_multiple.rgb *= visibility_along(end);
#endif
#endif
#endif
}
