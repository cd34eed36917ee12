#version 330 core
// The map of what overlapping moons hide together: light that the sum of their parts takes more than once.

#include "visibility.glsl"
#include "joint.glsl"

uniform vec3 u_box_low;   // m, of the map's corner in the sun's frame
uniform vec3 u_box_step;  // m, between texels across, down and between layers

out vec4 out_overlap;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 place = vec3(texel.x, texel.y % OVERLAP_TEXELS, texel.y / OVERLAP_TEXELS);
  vec3 p = u_box_low + place * u_box_step;
  vec3 discs[MAX_DISCS];
#ifdef HAS_NARROW_MOONS
  for (int i = 0; i < NARROW_MOONS; ++i) {
    vec4 moon = narrow_moon(p, i);
    discs[i] = vec3(-moon.zw, moon.y) / moon.x;
  }
#endif
#ifdef HAS_WIDE_MOONS
  for (int i = 0; i < WIDE_MOONS; ++i) discs[u_disc_count - WIDE_MOONS + i] = wide_moon(p, i);
#endif
  float sum = -hidden_by_all(discs);
  for (int i = 0; i < u_disc_count; ++i) sum += hidden_by_one(discs[i]);
  out_overlap = vec4(max(sum, 0.0), 0.0, 0.0, 0.0);
}
