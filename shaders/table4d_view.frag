#version 330 core
// The inscatter table at the camera's height and under its sun: across nu, up mu, as table4d.glsl looks it up.
//
// A camera inside the air fixes two of the four axes for every pixel. What is mixed along those two here is what every
// lookup would mix again, so the result is the same.

#include "camera.glsl"
#include "table4d_mapping.glsl"

uniform Axis u_shadow_axis;
uniform sampler2D u_inscatter;
uniform sampler2D u_inscatter_multiple;

layout(location = 0) out vec4 out_inscatter;
layout(location = 1) out vec4 out_multiple;

void main() {
  vec2 sun = vec2(-u_shadow_axis.z, 0.0);
  float r = u_bottom_radius + altitude_of(u_camera_k);
  vec4 place = inscatter_place(u_camera_k, r, sun, u_camera_k - r * r, false);
  ivec2 texel = ivec2(gl_FragCoord.xy);
  float cosines = TILES.x - 1.0;
  TableCell cell = inscatter_cell(vec4(place.x, 0.0, place.z, float(texel.x) / cosines), true);
  // on a cosine of the table, and in the row of this texel
  float column = float(texel.x) * TILE.x + 0.5 + place.z * (TILE.x - 1.0);
  cell.corner = vec2(column / (TILE.x * TILES.x), cell.corner.y + float(texel.y) / (TILE.y * TILES.y));
  cell.part.x = 0.0;
  out_inscatter = inscatter_fetch(u_inscatter, cell);
  out_multiple = inscatter_fetch(u_inscatter_multiple, cell);
}
