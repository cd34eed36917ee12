#version 330 core
// Pass 5, second half: the scene behind the air, dimmed, plus the light that the air scatters into the ray.

#include "camera.glsl"
#ifdef HAS_AIR
#ifdef HAS_SEGMENTS
#include "segments.glsl"
#endif
#ifdef HAS_TABLE3D
#include "table3d.glsl"
#endif
#ifdef HAS_TABLE4D
#include "table4d.glsl"
#endif
#ifdef HAS_WIDTHS
#include "path_widths.glsl"
#endif
#ifdef HAS_MULTIPLE_VIEW
#include "multiple.glsl"
#include "multiple_view.glsl"
#endif
#endif
#ifdef HAS_SUN_DISC
#include "sun_disc.glsl"
#endif

uniform vec3 u_irradiance;
uniform Axis u_shadow_axis;
uniform sampler2D u_cuts;
#ifdef HAS_BACKGROUND
uniform sampler2D u_background;
#endif

#ifdef HAS_ECLIPSE
uniform vec3 u_camera_position;  // m
#endif

out vec4 out_color;  // a: how much of the background the air hides

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 background = vec3(0.0);
#ifdef HAS_BACKGROUND
  background = texelFetch(u_background, texel, 0).rgb;
#endif
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  vec3 across = cross(pixel.direction, u_shadow_axis.direction);
  float nu = -dot(pixel.direction, u_shadow_axis.direction);
#ifdef HAS_SUN_DISC
  bool open = isinf(texelFetch(u_cuts, texel, 0).x);
  float hidden = 0.0;
#ifdef HAS_MOONS
  hidden = behind_moons(pixel.direction);
#endif
  background += open ? u_irradiance * sun_disc(length(across), nu, hidden) : vec3(0.0);
#endif
#ifdef HAS_AIR
  Ray ray = pixel_ray(pixel);
  vec2 sun = vec2(-base_height(pixel, ray, u_shadow_axis, across, -nu), nu);
#ifdef HAS_ECLIPSE
  eclipse_base = base_point(pixel, ray, u_camera_position);
  eclipse_direction = pixel.direction;
#endif
  vec4 cuts = vec4(0.0, texelFetch(u_cuts, texel, 0).yzw);
  Scattered air = scatter(ray, sun, dot(across, across), cuts);
#ifdef HAS_MULTIPLE_VIEW
#ifdef HAS_HIGH_CAMERA
  vec3 multiple = multiple_inscatter(ray, pixel.direction, cuts.w, air.transmittance);
#else
  vec3 multiple = multiple_inscatter(gl_FragCoord.xy, cuts.w, air.transmittance);
#endif
#ifdef HAS_ECLIPSE
  multiple *= diffuse_visibility(air.visibility);
#endif
  air.radiance += multiple;
#endif
  out_color = vec4(air.transmittance * background + u_irradiance * air.radiance, 1.0 - dot(air.transmittance, vec3(1.0 / 3.0)));
#else
  out_color = vec4(background, 0.0);
#endif
}
