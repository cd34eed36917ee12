#version 330 core
// A texture as it is, into another framebuffer of the same size.

uniform sampler2D u_color;

out vec4 out_color;

void main() {
  out_color = texelFetch(u_color, ivec2(gl_FragCoord.xy), 0);
#ifdef HAS_NO_ALPHA
  out_color.a = 0.0;
#endif
}
