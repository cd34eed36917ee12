// The four axes of the inscatter table of Bruneton and Neyret 2008: r, mu, mu_s, nu, in the mapping of Bruneton 2017.
//
// mu goes by the distance to where the ray ends, in two halves: rays that meet the ground and rays that leave through
// the top. Between them, at the horizon, light jumps, and no lookup mixes across. mu_s goes by the distance to the top
// at sea level, which crowds texels where the sun is low. The table is an atlas: a tile for each nu (across) and r (up),
// inside a tile mu_s across and mu up, so that a lookup is four bilinear fetches. Twin: shadowatmo/table4d.py.

#include "ray.glsl"

uniform float u_sun_axis;  // place of the lowest sun on the rational scale of mu_s

const vec2 TILE = vec2(float(INSCATTER_SUNS), float(INSCATTER_VIEWS));
const vec2 TILES = vec2(float(INSCATTER_COSINES), float(INSCATTER_HEIGHTS));

// What a texel stands for: a view path and the sun's height above its base point's terminator plane [m] and cosine.
struct TablePath {
  Ray ray;
  float end;    // m, length of the path
  bool ground;  // where it ends
  vec2 sun;
};

// A place in the table: texture coordinates of the lowest of four fetches, and the parts of the upper ones.
struct TableCell {
  vec2 corner;
  vec2 part;
};

float sea_level_distance(float mu_s) {
  float y = u_bottom_radius * mu_s;
  return far_root(y, -u_top_k, sqrt(y * y + u_top_k));
}

float sun_axis(float mu_s) {
  float a = (sea_level_distance(mu_s) - u_thickness) / (sqrt(u_top_k) - u_thickness);
  return max(1.0 - a / u_sun_axis, 0.0) / (1.0 + a);
}

float sun_of_axis(float unit) {
  float a = u_sun_axis * (1.0 - unit) / (1.0 + unit * u_sun_axis);
  float distance = u_thickness + a * (sqrt(u_top_k) - u_thickness);
  return clamp((u_top_k - distance * distance) / (2.0 * distance * u_bottom_radius), -1.0, 1.0);
}

// Places 0..1 along r, mu (within its half), mu_s and nu of a point on a path.
vec4 inscatter_place(float k, float x, vec2 sun, float tangent_k, bool ground) {
  float rho_top = sqrt(u_top_k);
  float rho = min(safe_sqrt(k), rho_top);
  float altitude = altitude_of(max(k, 0.0));
  float to_ground = max(k, 0.0) / max(safe_sqrt(-tangent_k) - x, 1.0e-30);
  float to_top = far_root(x, k - u_top_k, safe_sqrt(u_top_k - tangent_k));
  float nearest = ground ? altitude : u_thickness - altitude;
  float farthest = ground ? rho : rho + rho_top;
  float view = ((ground ? to_ground : to_top) - nearest) / max(farthest - nearest, 1.0e-6 * rho_top);
  float mu_s = clamp(sun.x / (u_bottom_radius + altitude), -1.0, 1.0);
  return clamp(vec4(rho / rho_top, view, sun_axis(mu_s), 0.5 + 0.5 * sun.y), 0.0, 1.0);
}

// Row, in texels, of a place in its half of mu.
float view_row(float unit, bool ground) {
  float half_views = 0.5 * TILE.y;
  return 0.5 + unit * (half_views - 1.0) + (ground ? 0.0 : half_views);
}

TableCell inscatter_cell(vec4 place, bool ground) {
  vec2 inside = vec2(0.5 + place.z * (TILE.x - 1.0), view_row(place.y, ground));
  vec2 tile = place.wx * (TILES - 1.0);
  vec2 first = min(floor(tile), max(TILES - 2.0, 0.0));
  return TableCell((first * TILE + inside) / (TILE * TILES), tile - first);
}

// Texture coordinates in the table of one camera, nu across and mu up.
vec2 view_texel(vec2 place, bool ground) {
  return vec2(0.5 + place.x * (TILES.x - 1.0), view_row(place.y, ground)) / vec2(TILES.x, TILE.y);
}

TableCell inscatter_at(float k, float x, vec2 sun, float tangent_k, bool ground) {
  return inscatter_cell(inscatter_place(k, x, sun, tangent_k, ground), ground);
}

vec4 inscatter_fetch(sampler2D table, TableCell cell) {
  vec2 next = 1.0 / TILES;
  vec4 low = mix(texture(table, cell.corner), texture(table, cell.corner + vec2(next.x, 0.0)), cell.part.x);
  vec4 high = mix(texture(table, cell.corner + vec2(0.0, next.y)), texture(table, cell.corner + next), cell.part.x);
  return mix(low, high, cell.part.y);
}

float altitude_axis_k(float unit) { return unit * unit * u_top_k; }

// The path of the texel at a place; the inverse of inscatter_place. A nu that no path of this mu and mu_s has is moved
// to the nearest that one has.
TablePath inscatter_path(vec4 place, bool ground) {
  float rho_top = sqrt(u_top_k);
  float rho = place.x * rho_top;
  float k = altitude_axis_k(place.x);
  float altitude = altitude_of(k);
  float r = u_bottom_radius + altitude;
  float nearest = ground ? altitude : u_thickness - altitude;
  float farthest = ground ? rho : rho + rho_top;
  float d = nearest + place.y * (farthest - nearest);
  float c = ground ? k : k - u_top_k;
  float x = d > 1.0e-3 ? -0.5 * (d + c / d) : (ground ? -r : r);
  x = ground ? clamp(x, -r, -rho) : clamp(x, -rho, r);
  float half_sum = d > 1.0e-3 ? 0.5 * (k / d - d) : 0.0;
  float tangent_k = ground ? (d > 1.0e-3 ? -half_sum * half_sum : k - x * x) : (x < 0.0 ? max(k - x * x, 0.0) : k - x * x);
  float mu = x / r;
  float mu_s = sun_of_axis(place.z);
  float spread = safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s));
  float nu = clamp(2.0 * place.w - 1.0, mu * mu_s - spread, mu * mu_s + spread);
  return TablePath(Ray(x, k, tangent_k, 0.0, d), d, ground, vec2(r * mu_s, clamp(nu, -1.0, 1.0)));
}

// Height, view and sun of a texel, each counted from 0.
ivec3 inscatter_index(ivec2 texel) {
  ivec2 tile = texel / ivec2(TILE);
  ivec2 inside = texel - tile * ivec2(TILE);
  return ivec3(tile.y, inside.y, inside.x);
}

TablePath inscatter_texel(ivec2 texel) {
  ivec3 index = inscatter_index(texel);
  int half_views = INSCATTER_VIEWS / 2;
  bool ground = index.y < half_views;
  float view = float(ground ? index.y : index.y - half_views) / float(half_views - 1);
  float cosine = float(texel.x / INSCATTER_SUNS) / (TILES.x - 1.0);
  return inscatter_path(vec4(float(index.x) / (TILES.y - 1.0), view, float(index.z) / (TILE.x - 1.0), cosine), ground);
}
