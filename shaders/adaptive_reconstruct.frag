#version 330 core
// A window of the frame by interpolation between the corners of the tiles.

#include "output.glsl"

uniform sampler2D u_light;
uniform vec2 u_grid;  // 1 / samples
#ifdef HAS_IN_PLACE
uniform sampler2D u_clear;
#endif
#ifdef HAS_BACKGROUND
uniform sampler2D u_clear;
uniform sampler2D u_background;
#endif
#ifdef HAS_TILES
uniform sampler2D u_tiles;
#endif

void main() {
#ifdef HAS_TILES
  if (texelFetch(u_tiles, ivec2(gl_FragCoord.xy) / TILE_PIXELS, 0).x > 0.0) discard;  // to be added by itself
#endif
  vec2 place = ((gl_FragCoord.xy - 0.5) / float(TILE_PIXELS) + 0.5) * u_grid;
  vec4 light = texture(u_light, place);
#ifdef HAS_IN_PLACE
  vec4 clear = texture(u_clear, place);
  if (mod(floor(clear.a + 0.5), 2.0) < 0.5) discard;  // no corner has air (adaptive.glsl): what is there keeps its bits
  out_passed = clear;
#endif
#ifdef HAS_BACKGROUND
  light.rgb += texture(u_clear, place).rgb * texelFetch(u_background, ivec2(gl_FragCoord.xy), 0).rgb;
#endif
  out_color = light;
}
