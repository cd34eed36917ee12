// Maps of a planet: equirectangular, 180 W at the left edge, the north pole at the top.

#include "phase.glsl"
#include "ray.glsl"

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

vec4 smooth_map(sampler2D map, vec2 uv, float level) {
  float lower = floor(level);
  vec4 a = cubic_texture(map, uv, lower);
  return level > 0.0 ? mix(a, cubic_texture(map, uv, lower + 1.0), level - lower) : a;
}
