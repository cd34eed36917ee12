// Multiple scattering along the pixels' rays under moons over that without them, from a coarse table of one camera.
//
// The pixel knows which part of the sun its light has seen, which carries the edges of the shadow; what is left of the
// logarithm of the ratio is smooth. Across and up cells of the part of the frame that shows air; the slices lie one over
// the other. Low cameras: the slices are distances, and the ground is transparent, so that the horizon is no edge. High
// ones (HAS_HIGH_CELLS): the altitude at which a descending path ends; the last one holds whole paths, and is the only one
// where nothing else ends a path (HAS_ONE_SLICE).

#include "shade.glsl"

uniform vec4 u_cells;         // pixels to texels of a slice: scale, offset
uniform vec2 u_cells_size;    // texels of a slice
uniform vec2 u_cell_slices;   // m, scale of the distances; 1 / log(1 + farthest / scale)

const float LAST_CELL_SLICE = float(CELL_SLICES - 1);

#ifdef HAS_HIGH_CELLS
// Where the path of a slice ends, and the slice of a path that ends at t [m].
float cell_end(Ray ray, float slice) {
#ifdef HAS_ONE_SLICE
  float h = 0.0;
#else
  float unit = 1.0 - slice / LAST_CELL_SLICE;
  float h = u_thickness * unit * unit;
#endif
  float end_k = h * (2.0 * u_bottom_radius + h) - ray.tangent_k;
  bool ground = ray.tangent_k < 0.0 && ray.x < 0.0;
  bool descends = ray.x < 0.0 && end_k > 0.0 && (h > 0.0 || ground);
  return descends ? max(-ray.x - sqrt(end_k), 1.0e-3 * u_thickness) : ray.air;
}
float cell_slice(Ray ray, float t) {
  float altitude = ray.x + t < 0.0 ? altitude_of(max(k_along(ray, t), 0.0)) : 0.0;
  return (1.0 - sqrt(clamp(altitude / u_thickness, 0.0, 1.0))) * LAST_CELL_SLICE;
}
#else
float cell_end(Ray ray, float slice) {
  float distance = u_cell_slices.x * (exp(slice / (LAST_CELL_SLICE * u_cell_slices.y)) - 1.0);
  return min(max(distance, 1.0e-3 * u_cell_slices.x), ray.air);
}
float cell_slice(Ray ray, float t) {
  return clamp(log(1.0 + max(t, 0.0) / u_cell_slices.x) * u_cell_slices.y, 0.0, 1.0) * LAST_CELL_SLICE;
}
#endif

#ifdef HAS_ECLIPSE_VIEW
uniform sampler2D u_eclipse_view;

// Logarithm of the ratio over shade(), for a path that ends at `end` [m] after its base.
vec3 eclipse_remainder(vec2 fragment, Ray ray, float end) {
  vec2 texel = clamp(fragment * u_cells.xy + u_cells.zw, vec2(0.5), u_cells_size - 0.5);
#ifdef HAS_ONE_SLICE
  return texture(u_eclipse_view, texel / u_cells_size).rgb;
#else
  float slice = cell_slice(ray, end);
  float low = min(floor(slice), LAST_CELL_SLICE - 1.0);
  vec2 place = (texel + vec2(0.0, low * u_cells_size.y)) / (u_cells_size * vec2(1.0, float(CELL_SLICES)));
  vec3 near = texture(u_eclipse_view, place).rgb;
  vec3 far = texture(u_eclipse_view, place + vec2(0.0, 1.0 / float(CELL_SLICES))).rgb;
  return mix(near, far, slice - low);
#endif
}
#endif
