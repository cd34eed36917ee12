#version 330 core
// Solve, step 6: the source over directions, as the atlas that multiple.glsl reads.

uniform sampler2D u_source;
uniform float u_turns[TURN_COUNT];  // lines fitted to cos(m azimuth), at azimuth 0 first

out vec4 out_table;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  ivec2 tile = texel / ivec2(MULTIPLE_SUNS, MULTIPLE_LAYERS);
  ivec2 inside = texel - tile * ivec2(MULTIPLE_SUNS, MULTIPLE_LAYERS);
  int row = inside.y * MULTIPLE_SUNS + inside.x;
  vec3 sum = vec3(0.0);
  for (int m = 0; m <= DEGREE; ++m) {
    sum += u_turns[tile.y * (DEGREE + 1) + m] * texelFetch(u_source, ivec2(m * MULTIPLE_POLAR + tile.x, row), 0).rgb;
  }
  // A truncated series may dip below zero beside a sharp peak, and dark corners may leave half-float's range.
  out_table = vec4(clamp(sum, 0.0, 6.0e4), 1.0);
}
