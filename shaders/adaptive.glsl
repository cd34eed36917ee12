// Tiles of the frame: the air is evaluated at their corners and interpolated where it is smooth.
//
// Sample (i, j) of the grid is the pixel (i, j) TILE_PIXELS; the tile (i, j) has the samples (i, j) to (i + 1, j + 1) at
// its corners. The last samples may lie outside of the frame. What a sample's path is like goes with it as a code.

#include "cuts.glsl"

uniform ivec2 u_size;  // pixels

const float WITH_AIR = 1.0;
const float WITH_SHADOW = 2.0;
const float LIT_BEFORE = 4.0;   // the shadow
const float LIT_BEHIND = 8.0;
const float WITH_SOLID = 16.0;
const float WITH_GROUND = 32.0;
const float SHADOW_BEHIND = 64.0;  // a shadow on the way to the ground or the top, before or behind a solid

const float INTERPOLATED = 0.0;  // kinds of tiles; the others are the classes of widths.frag, of all pixels of a tile
const float LIT_TILE = 1.0;
const float SHADOW_TILE = 2.0;
const float MIXED_TILE = 3.0;
const float CURVED_TILE = 4.0;   // interpolated too, by parabolas in the logarithm

vec2 sample_place(vec2 number) { return float(TILE_PIXELS) * number + 0.5; }
ivec2 sample_texel(vec2 number) { return clamp(ivec2(float(TILE_PIXELS) * number), ivec2(0), u_size - 1); }

float path_code(ivec2 texel, Pixel pixel, Ray ray, vec4 cuts) {
  if (ray.air < 0.0) return cuts.x < NOTHING ? WITH_SOLID : 0.0;
  float ground = ground_distance(ray);
  vec2 shadow = shadow_along(texel, pixel, ray);
  bool behind = min(shadow.y, ground >= 0.0 ? ground : ray.air) > max(shadow.x, 0.0);
  float code = WITH_AIR + (cuts.x < NOTHING ? WITH_SOLID : 0.0) + (ground >= 0.0 ? WITH_GROUND : 0.0);
  if (is_cut(cuts)) code += WITH_SHADOW + (cuts.y > 0.0 ? LIT_BEFORE : 0.0) + (cuts.z < cuts.w ? LIT_BEHIND : 0.0);
  return code + (behind || is_cut(cuts) ? SHADOW_BEHIND : 0.0);
}

bool code_has(float code, float part) { return mod(floor(code / part), 2.0) > 0.5; }
