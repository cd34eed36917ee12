// Multiple scattering along the pixels' rays, from a coarse table of one camera.
//
// Along a path of transmittance T the inscatter is M (1 - T), M = the mean of source over extinction, weighted by how much
// of the path's extinction happens where. (1 - T), which the pixel knows, carries the horizon, the terrain, the limb and
// the density; M is so smooth that few texels of its logarithm do. Slices lie one over the other: a lookup is two bilinear fetches.
//
// Low cameras: across and up the corners of cells of the frame; the slices are distances. For M the ground is transparent,
// its air as dense as at altitude 0, so that the horizon is no edge.
// High ones, and all where nothing but the ground's sphere and the top ends a path (HAS_HIGH_CAMERA): across the azimuth
// from the sun about the nadir, or from far away (HAS_SUN_COLUMNS) the sun's height where the ray meets the ground or is the
// nearest to it; up the rays that meet the ground, by their slope there, and over them those that do not, by
// the altitude of their tangent point, then by their own slope where they rise. The slices are the altitude at which a
// descending path ends; the last one holds whole paths, and is the only one where there are no others (HAS_WHOLE_PATHS).

uniform vec2 u_view_size;    // texels of a slice
uniform vec2 u_view_slices;  // m, scale of the distances; 1 / log(1 + farthest / scale)

const float LAST_SLICE = float(SLICES - 1);

#ifdef HAS_HIGH_CAMERA
uniform vec3 u_view_top;     // m, highest tangent point; share of rows for tangent points; camera's distance from the center
#ifdef HAS_SUN_COLUMNS
uniform vec4 u_view_columns; // where the columns are the closest, as -mu_s; width about it; first and span, stretched

// Where a ray meets the ground, or is the nearest to it: distance from a point on the ray with that x [m], and from the
// planet's center.
vec2 view_point(float x, float tangent_k) {
  bool ground = tangent_k < 0.0 && x < 0.0;
  float lowest = altitude_of(max(tangent_k, 0.0));
  return ground ? vec2(-x - safe_sqrt(-tangent_k), u_bottom_radius) : vec2(-x, u_bottom_radius + lowest);
}

// Column 0..1 by the cosine of the sun's zenith angle there, and its inverse: close together in twilight.
float view_column(float mu_s) {
  float z = (mu_s + u_view_columns.x) / u_view_columns.y;
  return (log(z + sqrt(z * z + 1.0)) - u_view_columns.z) / u_view_columns.w;
}
float view_sun(float column) {
  float e = exp(u_view_columns.z + u_view_columns.w * column);
  return clamp(0.5 * u_view_columns.y * (e - 1.0 / e) - u_view_columns.x, -1.0, 1.0);
}
#else
uniform vec3 u_view_up;      // from the center to the camera
uniform vec3 u_view_toward;  // horizontal, to the side of the sun
#endif

// Row 0..1 in its half of the table.
float view_row(float x, float tangent_k) {
  if (tangent_k < 0.0 && x < 0.0) return sqrt(min(sqrt(-tangent_k) / u_bottom_radius, 1.0));
  float lowest = sqrt(clamp(altitude_of(tangent_k) / u_view_top.x, 0.0, 1.0));
  return x < 0.0 ? u_view_top.y * lowest : u_view_top.y + (1.0 - u_view_top.y) * sqrt(min(x / u_view_top.z, 1.0));
}

// x and tangent_k of the camera's ray in a row; k of the camera.
vec2 view_ray(float row, bool ground, float k) {
  float h = u_view_top.x * row * row / (u_view_top.y * u_view_top.y);
  float tangent_k = ground ? -u_bottom_radius * u_bottom_radius * row * row * row * row : h * (2.0 * u_bottom_radius + h);
  if (ground || row <= u_view_top.y) return vec2(-safe_sqrt(k - tangent_k), tangent_k);
  float slope = (row - u_view_top.y) / max(1.0 - u_view_top.y, 1.0e-6);
  float x = u_view_top.z * slope * slope;
  return vec2(x, k - x * x);
}
#else
float slice_distance(float slice) { return u_view_slices.x * (exp(slice / (LAST_SLICE * u_view_slices.y)) - 1.0); }
#endif

#ifdef HAS_MULTIPLE_VIEW
uniform sampler2D u_multiple_view;

vec3 view_mean(vec2 texel, float slice) {
#ifdef HAS_WHOLE_PATHS
  return exp(texture(u_multiple_view, texel / u_view_size).rgb);
#else
  float low = min(floor(slice), LAST_SLICE - 1.0);
  vec2 place = (texel + vec2(0.0, low * u_view_size.y)) / (u_view_size * vec2(1.0, float(SLICES)));
  vec3 near = texture(u_multiple_view, place).rgb;
  vec3 far = texture(u_multiple_view, place + vec2(0.0, 1.0 / float(SLICES))).rgb;
  return exp(mix(near, far, slice - low));
#endif
}

#ifdef HAS_HIGH_CAMERA
// Inscatter [1/sr] per unit irradiance, all orders from the second on, of a path that ends at `end` [m] after its base.
vec3 multiple_inscatter(Ray ray, vec3 direction, vec2 sun, float end, vec3 transmittance) {
  float half_rows = 0.5 * u_view_size.y;
  bool ground = ray.tangent_k < 0.0 && ray.x < 0.0;
#ifdef HAS_SUN_COLUMNS
  float row = view_row(ray.x, ray.tangent_k);
  vec2 point = view_point(ray.x, ray.tangent_k);
  float column = clamp(view_column((sun.x + sun.y * point.x) / point.y), 0.0, 1.0);
#else
  float camera_x = dot(direction, u_view_up) * u_view_top.z;
  float row = view_row(min(camera_x, ray.x < 0.0 ? -1.0 : camera_x), ray.tangent_k);
  float c = dot(direction, u_view_toward) * inversesqrt(max(dot(cross(direction, u_view_up), cross(direction, u_view_up)), 1.0e-20));
  float column = angle_over_pi(clamp(c, -1.0, 1.0));
#endif
  vec2 texel = 0.5 + vec2(column, row) * (vec2(u_view_size.x, half_rows) - 1.0);
  bool descends = ray.x + end < 0.0;
  float altitude = descends ? altitude_of(max(k_along(ray, end), 0.0)) : 0.0;
  float slice = (1.0 - sqrt(clamp(altitude / u_thickness, 0.0, 1.0))) * LAST_SLICE;
  return view_mean(texel + vec2(0.0, ground ? 0.0 : half_rows), slice) * (1.0 - transmittance);
}
#else
// The same of a pixel's path, by its length [m].
vec3 multiple_inscatter(vec2 fragment, float end, vec3 transmittance) {
  float slice = clamp(log(1.0 + end / u_view_slices.x) * u_view_slices.y, 0.0, 1.0) * LAST_SLICE;
  return view_mean(fragment / float(CELL) + 0.5, slice) * (1.0 - transmittance);
}
#endif
#endif
