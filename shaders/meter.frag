#version 330 core
// A light meter: each pixel of a small target takes the mean of a grid of samples from its part of a linear picture.

uniform sampler2D u_color;
uniform vec2 u_cell;  // pixels of the picture that belong to a pixel of the target

out vec4 out_color;

const int SAMPLES = 4;  // a side

void main() {
  vec3 sum = vec3(0.0);
  for (int j = 0; j < SAMPLES; ++j) {
    for (int i = 0; i < SAMPLES; ++i) {
      vec2 offset = (vec2(i, j) + 0.5) / float(SAMPLES);
      sum += texelFetch(u_color, ivec2((floor(gl_FragCoord.xy) + offset) * u_cell), 0).rgb;
    }
  }
  out_color = vec4(sum / float(SAMPLES * SAMPLES), 1.0);
}
