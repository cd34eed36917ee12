#version 330 core
// Solve, step 5: the source's Fourier coefficients at the table's zenith angles. Across: m, inside it the zenith angle.

uniform sampler2D u_scaled;
uniform sampler2D u_polar;  // lines fitted to the polar functions; across: the coefficient, up: the zenith angle

out vec4 out_source;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int m = texel.x / MULTIPLE_POLAR;
  int zenith = texel.x - m * MULTIPLE_POLAR;
  int first = m * (DEGREE + 1) - m * (m - 1) / 2;
  vec3 sum = vec3(0.0);
  for (int i = first; i <= first + DEGREE - m; ++i) {
    sum += texelFetch(u_polar, ivec2(i, zenith), 0).x * texelFetch(u_scaled, ivec2(i, texel.y), 0).rgb;
  }
  out_source = vec4(sum, 1.0);
}
