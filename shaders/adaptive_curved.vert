#version 330 core
// The tiles that are interpolated by parabolas: what each pixel needs of its tile.

#include "adaptive_tile.glsl"

uniform sampler2D u_light;
uniform sampler2D u_below;  // what the tile's sides bend by, see adaptive_tiles.frag
uniform sampler2D u_above;
uniform sampler2D u_left;
uniform sampler2D u_right;
#ifdef HAS_CLEAR
uniform sampler2D u_clear;
uniform sampler2D u_clear_across;
uniform sampler2D u_clear_up;
#endif

flat out vec4 v_light[4];  // of the corners: logarithms, and the opacity
flat out vec4 v_bend[4];   // of the sides
#ifdef HAS_CLEAR
flat out vec3 v_clear[4];
flat out vec3 v_clear_bend[2];
#endif

void main() {
  ivec2 tile = place_tile();
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = tile + ivec2(i & 1, i >> 1);
    vec4 light = texelFetch(u_light, corner, 0);
    v_light[i] = vec4(log(max(light.rgb, 1.0e-30)), light.a);
#ifdef HAS_CLEAR
    v_clear[i] = log(max(texelFetch(u_clear, corner, 0).rgb, 1.0e-30));
#endif
  }
  v_bend[0] = texelFetch(u_below, tile, 0);
  v_bend[1] = texelFetch(u_above, tile, 0);
  v_bend[2] = texelFetch(u_left, tile, 0);
  v_bend[3] = texelFetch(u_right, tile, 0);
#ifdef HAS_CLEAR
  v_clear_bend[0] = texelFetch(u_clear_across, tile, 0).rgb;
  v_clear_bend[1] = texelFetch(u_clear_up, tile, 0).rgb;
#endif
}
