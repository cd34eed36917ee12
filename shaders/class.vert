#version 330 core
// One triangle over the viewport at the depth of a class of pixels: with the depth test on equality only pixels of that
// class are shaded, each by a shader without loops or branches over pieces.

uniform float u_class;

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(corner, 0.5 * u_class - 1.0, 1.0);
}
