#version 330 core
// Solve, step 4 too: logarithm of the mean radiance (altitude up, sun across), or of the ground's irradiance (one row).

#include "multiple_field.glsl"

uniform int u_coefficient;
uniform float u_scale;

out vec4 out_level;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  out_level = vec4(log(max(u_scale * field_moment(u_coefficient, texel.y * MULTIPLE_SUNS + texel.x), DARK)), 1.0);
}
