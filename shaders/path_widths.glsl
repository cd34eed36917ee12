// The published method: brightness by the widths of lit and shadowed air, 3 (lit + 0.2 shadowed) / (far - near).

#include "ray.glsl"

uniform vec4 u_air_color;  // color of a unit of brightness, per unit irradiance; a: opacity of a unit of brightness
uniform float u_range;     // m, far - near: from the nearest to the farthest point of the air

struct Scattered {
  vec3 transmittance;
  vec3 radiance;  // 1/sr, per unit irradiance
};

Scattered scatter(Ray ray, vec2 sun, float across, vec4 cuts) {
  float shadowed = cuts.z - cuts.y;
  float lit = cuts.w - cuts.x - shadowed;
  float brightness = 3.0 * (lit + 0.2 * shadowed) / u_range;
  return Scattered(vec3(1.0 - u_air_color.a * clamp(brightness, 0.0, 1.0)), brightness * u_air_color.rgb);
}
