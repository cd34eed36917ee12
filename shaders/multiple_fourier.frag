#version 330 core
// Solve, step 2: moments over the azimuth. Across: m, inside it the zenith angle.

uniform sampler2D u_radiance;
uniform float u_turns[TURN_COUNT];  // weight times cos(m azimuth), the azimuths of m = 0 first

out vec4 out_moment;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int m = texel.x / POLAR_COUNT;
  int first = (texel.x - m * POLAR_COUNT) * AROUND;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < AROUND; ++i) sum += u_turns[m * AROUND + i] * texelFetch(u_radiance, ivec2(first + i, texel.y), 0).rgb;
  out_moment = vec4(sum, 1.0);
}
