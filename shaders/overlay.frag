#version 330 core
// Words over a picture: a texture with coverage in alpha, its top left corner at u_corner, one texel a pixel.

uniform sampler2D u_words;  // rows from the top down
uniform vec2 u_corner;      // pixels from the lower left corner of the target

out vec4 out_color;

void main() {
  ivec2 texel = ivec2(floor(vec2(gl_FragCoord.x - u_corner.x, u_corner.y - gl_FragCoord.y)));
  ivec2 size = textureSize(u_words, 0);
  if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) discard;
  out_color = texelFetch(u_words, texel, 0);
}
