#version 330 core
// The directions in which a camera can see the planet: a pyramid about the nadir, as a fan of triangles at infinity.

uniform mat3 u_local;  // columns: two tangents and the up vector at the camera
uniform mat3 u_view;   // rows right, up, forward, the first two over the tangents of the half angles
uniform vec2 u_cone;   // cosine and sine of the fan's angle from the nadir

void main() {
  int corner = gl_VertexID % 3;
  float turn = 6.28318530718 / float(FAN) * float(gl_VertexID / 3 + corner);
  vec3 rim = vec3(cos(turn) * u_cone.y, sin(turn) * u_cone.y, -u_cone.x);
  vec3 eye = u_view * (u_local * (corner == 2 ? vec3(0.0, 0.0, -1.0) : rim));
  gl_Position = vec4(eye.xy, 0.0, eye.z);
}
