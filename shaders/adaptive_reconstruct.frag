#version 330 core
// The whole frame by interpolation between the corners of the tiles.

uniform sampler2D u_light;
uniform vec2 u_grid;  // 1 / samples
#ifdef HAS_BACKGROUND
uniform sampler2D u_clear;
uniform sampler2D u_background;
#endif
#ifdef HAS_TILES
uniform sampler2D u_tiles;
#endif

out vec4 out_color;  // a: how much of the background the air hides

void main() {
  vec2 place = ((gl_FragCoord.xy - 0.5) / float(TILE_PIXELS) + 0.5) * u_grid;
  vec4 light = texture(u_light, place);
#ifdef HAS_BACKGROUND
  light.rgb += texture(u_clear, place).rgb * texelFetch(u_background, ivec2(gl_FragCoord.xy), 0).rgb;
#endif
#ifdef HAS_TILES
  light *= texelFetch(u_tiles, ivec2(gl_FragCoord.xy) / TILE_PIXELS, 0).x > 0.0 ? 0.0 : 1.0;  // to be added by itself
#endif
  out_color = light;
}
