#version 330 core
// Solve, step 3: moments over the zenith angle, hence the coefficients of the spherical harmonics; last the irradiance.

uniform sampler2D u_fourier;
uniform sampler2D u_basis;  // weight times polar function; across: the coefficient, up: altitude, inside it the zenith angle
uniform int u_degrees[COEFFICIENTS];  // m of the coefficient
uniform int u_first_column;

out vec4 out_moment;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy) - ivec2(u_first_column, 0);
  int column = u_degrees[texel.x] * POLAR_COUNT;
  int row = texel.y / MULTIPLE_SUNS * POLAR_COUNT;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < POLAR_COUNT; ++i) {
    float weight = texelFetch(u_basis, ivec2(texel.x, row + i), 0).x;
    sum += weight * texelFetch(u_fourier, ivec2(column + i, texel.y), 0).rgb;
  }
  out_moment = vec4(sum, 1.0);
}
