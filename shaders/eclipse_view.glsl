// Multiple scattering along the pixels' rays under moons over that without them, from a coarse table of one camera.
//
// The pixel knows which part of the sun its light has seen, which carries the edges of the shadow; what is left of the
// logarithm of the ratio is smooth. Across and up cells of the part of the frame that shows air; the slices, one over the
// other, are distances. Low cameras look through the ground, so that the horizon is no edge.

#include "shade.glsl"

uniform vec4 u_cells;         // pixels to texels of a slice: scale, offset
uniform vec2 u_cells_size;    // texels of a slice
uniform vec2 u_cell_slices;   // m, scale of the distances; 1 / log(1 + farthest / scale)

const float LAST_CELL_SLICE = float(CELL_SLICES - 1);

float cell_distance(float slice) { return u_cell_slices.x * (exp(slice / (LAST_CELL_SLICE * u_cell_slices.y)) - 1.0); }

#ifdef HAS_ECLIPSE_VIEW
uniform sampler2D u_eclipse_view;

// For a path that ends at `end` [m] after its base, and the mean visible fraction along it.
vec3 eclipse_ratio(vec2 fragment, float end, float visible) {
  vec2 texel = clamp(fragment * u_cells.xy + u_cells.zw, vec2(0.5), u_cells_size - 0.5);
  float slice = clamp(log(1.0 + max(end, 0.0) / u_cell_slices.x) * u_cell_slices.y, 0.0, 1.0) * LAST_CELL_SLICE;
  float low = min(floor(slice), LAST_CELL_SLICE - 1.0);
  vec2 place = (texel + vec2(0.0, low * u_cells_size.y)) / (u_cells_size * vec2(1.0, float(CELL_SLICES)));
  vec3 near = texture(u_eclipse_view, place).rgb;
  vec3 far = texture(u_eclipse_view, place + vec2(0.0, 1.0 / float(CELL_SLICES))).rgb;
  return shade(visible) * exp(mix(near, far, slice - low));
}
#endif
