#version 330 core
// The table of columns from a point to the top of the air: x molecules, y aerosols, z ozone (see transmittance.glsl).

#include "transmittance.glsl"

out vec4 out_columns;

void main() {
  vec2 ky = table_point(gl_FragCoord.xy);
  out_columns = vec4(integrated_columns(ky.x, ky.y), 0.0, 1.0);
#ifdef HAS_OZONE
  out_columns.z = ozone_to_top(ky.x, ky.y);
#endif
}
