// Columns of air from a point towards the sun, hence transmittance: the Chapman integral in closed form, or a table.
//
// A point and the direction are given by k (ray.glsl) and y = r mu_s = P . s [m], its height above the terminator plane;
// the sun's ray has its tangent point at k - y^2. The column of a layer of scale height H over an infinite exponential is
//   C = H exp(-h/H) sqrt(X/2) E(z) (1 + kappa(z)/X),  X = r/H, z = mu_s sqrt(X/2), E = sqrt(pi) exp(z^2) erfc(z),
// E and kappa / X by rational fits (TERMS 4: relative error 5e-4, 6: 2e-5 for X above a few hundred). Columns are in metres at
// altitude 0: x molecules, y aerosols, z ozone (metres at its peak).

#include "medium.glsl"
#include "ray.glsl"

#ifdef HAS_OZONE
// The tent is linear in altitude, and over a thin layer all but linear in k: the sum of three ramps in k. Along a ray k is
// tangent_k + x^2, so that the column is a cubic in x. The error is about half_width / (50 R) of the column.

// Relative density of the tent.
float ozone_density(float k) {
#ifdef HAS_CURVED_OZONE
  vec3 beyond = altitude_of(k) - u_ozone_altitude;
#else
  vec3 beyond = k - u_ozone_k;
#endif
  return max(dot(u_ozone_ramps, max(beyond, 0.0)), 0.0);
}

// Distances from the tangent point at which the tent begins, peaks and ends (or is cut by the top).
vec3 ozone_crossings(float tangent_k) { return sqrt(max(min(u_ozone_k, u_top_k) - tangent_k, 0.0)); }

// Column from the tangent point out to |x|, with the sign of x.
float ozone_to(float tangent_k, vec3 crossings, float x) {
  // From its crossing c on, a ramp's column is the integral of x^2 - c^2, and where the whole ray lies above its start
  // the ramp has begun already at the tangent point.
#ifdef HAS_CURVED_OZONE
  // Around a small planet the ramps run over the radius: the integral of sqrt(p^2 + s^2) has a closed form, too.
  float p2 = max(u_bottom_radius * u_bottom_radius + tangent_k, 1.0e-12 * u_bottom_radius * u_bottom_radius);
  float end = min(abs(x), crossings.z);
  vec3 from = min(crossings, end);
  float r_end = sqrt(p2 + end * end);
  vec3 r_from = sqrt(p2 + from * from);
  vec3 areas = 0.5 * (end * r_end - from * r_from + p2 * log((end + r_end) / (from + r_from)));
  vec3 ramps = max(areas - (u_bottom_radius + u_ozone_altitude) * (end - from), 0.0);
#else
  vec3 beyond = max(vec3(min(abs(x), crossings.z)) - crossings, 0.0);
  vec3 begun = max(tangent_k - u_ozone_k, 0.0);
  vec3 ramps = beyond * (beyond * (beyond + 3.0 * crossings) / 3.0 + begun);
#endif
  float column = max(dot(u_ozone_ramps, ramps), 0.0);
  return x < 0.0 ? -column : column;
}

float ozone_to_top(float k, float y) {
  float tangent_k = k - y * y;
  vec3 crossings = ozone_crossings(tangent_k);
  return max(ozone_to(tangent_k, crossings, 1.0e18) - ozone_to(tangent_k, crossings, y), 0.0);
}
#endif

#ifdef HAS_TABLE_MAPPING
// Bruneton and Neyret 2008, section 4: rows by the distance to the horizon, columns by the distance to the top. Every
// texel is a ray that does not meet the ground.
uniform vec2 u_table_size;

vec2 table_coordinates(float k, float y) {
  float rho = safe_sqrt(k);
  float rho_top = sqrt(u_top_k);
  float nearest = u_thickness - altitude_of(max(k, 0.0));
  float to_top = far_root(y, k - u_top_k, safe_sqrt(y * y + u_top_k - k));
  vec2 unit = vec2((to_top - nearest) / max(rho + rho_top - nearest, 1.0e-6 * rho_top), rho / rho_top);
  return (clamp(unit, 0.0, 1.0) * (u_table_size - 1.0) + 0.5) / u_table_size;
}

// The inverse at the center of a texel: k and y.
vec2 table_point(vec2 texel) {
  vec2 unit = (texel - 0.5) / (u_table_size - 1.0);
  float rho_top = sqrt(u_top_k);
  float rho = unit.y * rho_top;
  float k = rho * rho;
  float nearest = u_thickness - altitude_of(k);
  float to_top = nearest + unit.x * (rho + rho_top - nearest);
  // to_top is the root of d^2 + 2 y d + k - top_k = 0; at the top itself, looking up, it is 0 and so must y be large
  float y = (u_top_k - k - to_top * to_top) / max(2.0 * to_top, 1.0e-6 * rho_top);
  return vec2(k, clamp(y, -rho, u_bottom_radius + altitude_of(k)));
}
#endif

#ifdef COLUMN_COUNT
// Columns of the two exponential layers between distances [m] from the tangent point, rising from a point of given k, by
// quadrature in a sinh map whose width follows the thinner layer: where the closed form does not hold, and for the table.
vec2 integrate_layers(float k_start, float from, float to) {
  float r = max(u_bottom_radius + altitude_of(k_start), 0.5 * u_bottom_radius);
  float scale = min(min(u_scale_height.x, u_scale_height.y), u_thickness);
  float slope = from / r;
  float width = scale * inversesqrt(slope * slope + 0.5 * scale / r);
  float span = log((to - from) / width + sqrt((to - from) * (to - from) / (width * width) + 1.0));
  vec2 columns = vec2(0.0);
  for (int i = 0; i < u_column_count; ++i) {
    vec2 rule = u_column_rule[i];
    float e = exp(span * rule.x);
    float step = 0.5 * width * (e - 1.0 / e);
    float k = k_start + step * (step + 2.0 * from);
    columns += rule.y * 0.5 * width * span * (e + 1.0 / e) * densities(altitude_of(k));
  }
  return columns;
}

vec2 integrated_columns(float k, float y) {
  float tangent_k = k - y * y;
  float top = safe_sqrt(u_top_k - tangent_k);
  // A downward path first crosses its tangent point, and that part twice.
  if (y < 0.0) return integrate_layers(tangent_k, 0.0, -y) + integrate_layers(tangent_k, 0.0, top);
  return integrate_layers(k, y, max(top, y));
}
#endif

#ifdef HAS_TABLE
uniform sampler2D u_column_table;

vec3 columns_to_top(float k, float y) { return texture(u_column_table, table_coordinates(k, y)).xyz; }
#else

#if TERMS == 6
vec2 exponential_integral(vec2 z) {
  vec2 t = 1.0 / (1.0 + 0.460463 * z);
  return t * (0.4604722 + t * (0.45956096 + t * (0.4267281 + t * (0.22249795 + t * (0.42758318 - 0.22441785 * t)))));
}
// kappa(z) / x, with one division for both.
vec2 curvature(vec2 z, vec2 x) {
  return (0.375 + z * (0.64674 + 0.43184 * z)) / (x + x * z * (0.62824 + 0.43184 * z));
}
#else
vec2 exponential_integral(vec2 z) {
  vec2 t = 1.0 / (1.0 + 0.749563 * z);
  return t * (0.74999401 + t * (0.72509822 + t * (0.75344855 - 0.4570285 * t)));
}
vec2 curvature(vec2 z, vec2 x) { return (0.375 + 1.4714 * z) / (x + x * 1.4714 * z); }
#endif

// Columns to infinity of both layers, y >= 0.
vec2 upward_columns(float altitude, float y) {
  float r = u_bottom_radius + altitude;
  vec2 scale = sqrt(2.0 * u_scale_height * r);
  vec2 z = y / scale;
  return 0.5 * scale * densities(altitude) * exponential_integral(z) * (1.0 + curvature(z, r * u_falloff));
}

vec2 layer_columns(float k, float y) {
#ifdef COLUMN_COUNT
  return integrated_columns(k, y);
#else
  // A point whose sun is not hidden by the ground has its tangent point above it; elsewhere the clamp keeps the
  // exponential finite.
  float lowest = altitude_of(max(k - y * y, -0.5 * u_scale_height.y * u_bottom_radius));
  vec2 outward = upward_columns(altitude_of(k), abs(y));
  vec2 columns = y < 0.0 ? 2.0 * upward_columns(lowest, 0.0) - outward : outward;
#ifdef HAS_TOP
  float y_top = safe_sqrt(u_top_k - k + y * y);
  columns -= upward_columns(u_thickness, y_top);
#endif
  return max(columns, 0.0);
#endif
}

vec3 columns_to_top(float k, float y) {
#ifdef HAS_OZONE
  return vec3(layer_columns(k, y), ozone_to_top(k, y));
#else
  return vec3(layer_columns(k, y), 0.0);
#endif
}
#endif

// Transmittance (3 channels) from a point to the top of the air along the sun's direction, the ground ignored.
vec3 transmittance_to_top(float k, float y) { return exp(-optical_depth(columns_to_top(k, y))); }
