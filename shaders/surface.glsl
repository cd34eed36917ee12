// The lit ground (Schafhitzel et al. 2007, eq. 9-12): sunlight through the air, reflected by a Lambertian surface.

#include "transmittance.glsl"
#include "phase.glsl"
#include "camera.glsl"
#ifdef HAS_MULTIPLE
#include "multiple.glsl"
#endif
#ifdef HAS_ECLIPSE
#include "eclipse.glsl"
#endif
#ifdef HAS_WATER
#include "sky.glsl"
#include "water.glsl"
#endif

uniform Axis u_shadow_axis;
uniform vec3 u_irradiance;
uniform vec3 u_ground_albedo;
#ifdef HAS_COLOR_MAP
uniform sampler2D u_color_map;
#endif
#ifdef HAS_RELIEF
uniform sampler2D u_relief_map;  // slope to the east, slope to the north, altitude [m]
#endif
uniform float u_pixel_angle;  // rad, of a pixel in the middle of the frame

// Equirectangular coordinates of a point by its unit direction: 180 W at u = 0, the north pole at v = 1.
vec2 map_coordinates(vec3 up) {
  return vec2(atan(up.y, up.x) / (2.0 * PI) + 0.5, atan(up.z, length(up.xy)) / PI + 0.5);
}

// Cubic B-spline by four bilinear fetches: smooth where the map is magnified.
vec4 cubic_texture(sampler2D map, vec2 uv, float lod) {
  vec2 size = vec2(textureSize(map, int(lod)));
  vec2 position = uv * size - 0.5;
  vec2 f = fract(position);
  vec2 base = position - f;
  vec2 f2 = f * f;
  vec2 f3 = f2 * f;
  vec2 w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
  vec2 w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
  vec2 w3 = f3 / 6.0;
  vec2 near = w0 + w1;
  vec2 far = 1.0 - near;
  vec2 a = (base - 0.5 + w1 / near) / size;
  vec2 b = (base + 1.5 + w3 / far) / size;
  return near.y * (near.x * textureLod(map, a, lod) + far.x * textureLod(map, vec2(b.x, a.y), lod)) +
         far.y * (near.x * textureLod(map, vec2(a.x, b.y), lod) + far.x * textureLod(map, b, lod));
}

// Level of detail for a patch of ground seen from `distance` [m] at a slant; derivatives would tear at the date line.
float map_level(sampler2D map, float distance, float slant) {
  float footprint = distance * u_pixel_angle * inversesqrt(max(slant, 0.02));
  float texel = PI * u_bottom_radius / float(textureSize(map, 0).y);
  return max(log2(footprint / texel), 0.0);
}

vec3 smooth_map(sampler2D map, vec2 uv, float level) {
  float lower = floor(level);
  vec3 a = cubic_texture(map, uv, lower).xyz;
  return level > 0.0 ? mix(a, cubic_texture(map, uv, lower + 1.0).xyz, level - lower) : a;
}

#ifdef HAS_WATER
const float SEA_SHORE = 12.0;  // m; half a level of an 8-bit height map

// Light of sun and sky that the sea mirrors into the eye. to_eye = unit vector, sunlight = transmittance to the sun or 0.
vec3 mirrored(vec3 up, vec3 to_eye, vec3 sun, vec3 sunlight) {
  float mu = max(dot(up, to_eye), 1.0e-3);
  float mu_s = dot(up, sun);
  vec3 reflected = 2.0 * dot(up, to_eye) * up - to_eye;
  // Waves turn the mirror up where it is seen at a slant, so that it never shows the haze on the horizon alone.
  float above = max(dot(up, reflected), 0.06);
#ifdef HAS_ECLIPSE
  eclipse_base = up * u_bottom_radius;
  eclipse_direction = reflected;
#endif
  vec3 light = fresnel(mu) * sky(above, mu_s, dot(reflected, sun)).radiance;
  return mu_s > 0.0 ? light + sunlight * mu_s * glint(mu, max(mu_s, 0.01), dot(to_eye, sun)) : light;
}
#endif

// Radiance [1/sr] that the ground sends to the eye, before the air between. up = unit direction of the point, altitude
// [m], to_eye = unit vector, distance [m] to the eye.
vec3 ground_radiance(vec3 up, float altitude, vec3 to_eye, float distance) {
  float slant = max(dot(up, to_eye), 0.0);
  vec3 sun = -u_shadow_axis.direction;
  vec2 uv = map_coordinates(up);
  vec3 albedo = u_ground_albedo;
#ifdef HAS_COLOR_MAP
  albedo = smooth_map(u_color_map, uv, map_level(u_color_map, distance, slant));
#endif
  vec3 normal = up;
#ifdef HAS_RELIEF
  vec3 relief = smooth_map(u_relief_map, uv, map_level(u_relief_map, distance, slant));
  vec3 east = normalize(vec3(-up.y, up.x, 0.0) + vec3(0.0, 1.0e-9, 0.0));
  normal = normalize(up - relief.x * east - relief.y * cross(up, east));
  altitude = max(altitude, relief.z);
#endif
  // The terrain stands above the terminator plane's shadow edge by its altitude; its slope decides the rest.
  float height = dot(up, sun) * (u_bottom_radius + altitude);
  float k = altitude * (2.0 * u_bottom_radius + altitude);
  bool hidden = height < 0.0 && k < height * height;
  vec3 sunlight = hidden ? vec3(0.0) : transmittance_to_top(k, height);
#ifdef HAS_ECLIPSE
  float visible = sun_visibility(up * (u_bottom_radius + altitude));
  sunlight *= visible;
#endif
  vec3 light = sunlight * max(dot(normal, sun), 0.0);
#ifdef HAS_MULTIPLE
  // A slope sees the part of the sky above it; its light is taken as even over the sky.
  vec3 sky = ground_irradiance(dot(up, sun));
#ifdef HAS_ECLIPSE
  sky *= diffuse_visibility(visible);
#endif
  light += 0.5 * (1.0 + dot(normal, up)) * sky;
#endif
  vec3 radiance = albedo / PI * light;
#ifdef HAS_WATER
  float sea = 1.0 - smoothstep(0.0, SEA_SHORE, relief.z);
  radiance += sea * mirrored(up, to_eye, sun, sunlight);
#endif
  return u_irradiance * radiance;
}
