#version 330 core
// A tile between whose corners light and transmittance go by parabolas in the logarithm: twilight, the horizon and the limb
// fall off like exponentials, and the samples beside a tile tell how its sides bend.

#ifdef HAS_BACKGROUND
uniform sampler2D u_background;
#endif

flat in vec4 v_light[4];
flat in vec4 v_bend[4];  // of the sides below, above, to the left and to the right
#ifdef HAS_CLEAR
flat in vec3 v_clear[4];
flat in vec3 v_clear_bend[2];  // across and up
#endif

#include "output.glsl"

void main() {
  vec2 part = fract((gl_FragCoord.xy - 0.5) / float(TILE_PIXELS));
  vec2 arch = 0.5 * part * (1.0 - part);
  vec4 light = mix(mix(v_light[0], v_light[1], part.x), mix(v_light[2], v_light[3], part.x), part.y);
  light -= arch.x * mix(v_bend[0], v_bend[1], part.y) + arch.y * mix(v_bend[2], v_bend[3], part.x);
  out_color = vec4(exp(light.rgb), light.a);
#ifdef HAS_CLEAR
  vec3 clear = mix(mix(v_clear[0], v_clear[1], part.x), mix(v_clear[2], v_clear[3], part.x), part.y);
  clear -= arch.x * v_clear_bend[0] + arch.y * v_clear_bend[1];
#ifdef HAS_IN_PLACE
  out_passed = vec4(exp(clear), 1.0);
#endif
#ifdef HAS_BACKGROUND
  out_color.rgb += exp(clear) * texelFetch(u_background, ivec2(gl_FragCoord.xy), 0).rgb;
#endif
#endif
}
