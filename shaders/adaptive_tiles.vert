#version 330 core
// One triangle over the viewport. Its corners also look up how bright the frame is at most, from a sparse set of samples.

uniform sampler2D u_light;
uniform ivec4 u_samples;  // the window of the grid that was drawn

flat out float v_brightest;

const ivec2 SPARSE = ivec2(80, 45);

void main() {
  vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
  v_brightest = 0.0;
  ivec2 count = u_samples.zw - u_samples.xy;
  for (int y = 0; y < SPARSE.y; ++y) {
    for (int x = 0; x < SPARSE.x; ++x) {
      vec3 light = texelFetch(u_light, u_samples.xy + (2 * ivec2(x, y) + 1) * count / (2 * SPARSE), 0).rgb;
      v_brightest = max(v_brightest, max(light.r, max(light.g, light.b)));
    }
  }
}
