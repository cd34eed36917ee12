#version 330 core
// One triangle that covers the viewport, made from gl_VertexID alone: no vertex buffer is read.
// The triangle reaches to (3, 3), so no diagonal crosses the picture and no pixel is shaded twice.

void main() {
    vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
