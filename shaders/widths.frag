#version 330 core
// Pass 5, first half: linearize the depths and cut the view path through the air into lit and shadowed widths.
//
// Written are the cuts of cuts.glsl, the distance to the solid inf for none. The class that goes to the depth buffer
// selects the shader that draws the pixel: 0 no air, 1 lit, 2 one lit piece and a shadow, 3 a shadow between two lit pieces,
// and 4 lit: out to the top of the air where the method asks for it (HAS_OPEN_CLASS), or by a finite disc so high that it
// may be taken for a point (HAS_TERMINATOR). Seen from above (HAS_LONG_PATHS) lit paths past a tangent point in the densest
// air are of class 3 too: its shader has the nodes that they need, see segments.glsl.

#include "cuts.glsl"

#ifdef HAS_TERMINATOR
uniform float u_high_sun;  // m above the terminator plane
#endif

out vec4 out_cuts;

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  vec4 cuts = path_cuts(ivec2(gl_FragCoord.xy), pixel, ray);
  bool two_pieces = is_cut(cuts) && cuts.y > 0.0 && cuts.z < cuts.w;
  float kind = ray.air < 0.0 ? 0.0 : (two_pieces ? 3.0 : (is_cut(cuts) ? 2.0 : 1.0));
#ifdef HAS_TERMINATOR
  float toward_sun = -dot(pixel.direction, u_shadow_axis.direction);
  float height = -base_height(pixel, ray, u_shadow_axis, -toward_sun);
  kind = kind == 1.0 && min(height, height + cuts.w * toward_sun) > u_high_sun ? 4.0 : kind;
#endif
#ifdef HAS_OPEN_CLASS
  kind += kind == 1.0 && cuts.w >= air_end(ivec2(gl_FragCoord.xy), pixel, ray) ? 3.0 : 0.0;
#endif
#ifdef HAS_LONG_PATHS
  bool passes_tangent = ray.x < 0.0 && ray.x + cuts.w > 0.0;
  if (kind == 1.0 && passes_tangent && ray.tangent_k < DENSEST * u_top_k) kind = 3.0;
#endif
  out_cuts = vec4(cuts.x >= NOTHING ? uintBitsToFloat(0x7F800000u) : cuts.x, cuts.yzw);
  gl_FragDepth = 0.25 * kind;
}
