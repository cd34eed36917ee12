// The three axes of the tables without azimuth: height, view zenith and sun zenith. Twin: shadowatmo/table3d.py.
//
// Schafhitzel, Falk, Ertl 2007 rescale the three linearly. Elek 2009 (HAS_CURVED_MAPPING) takes the square root of
// k for the height and an exponential for the sun. Neither splits the view at the horizon, so its light mixes across.
// The table is an atlas of slices of equal height, INSCATTER_COLUMNS side by side, inside a slice sun across and view
// up: a trilinear lookup is two bilinear fetches.

#include "ray.glsl"

uniform float u_sun_azimuth;  // cosine of the azimuth between view and sun that the table assumes

const vec2 TILE = vec2(float(INSCATTER_SUNS), float(INSCATTER_VIEWS));
const vec2 TILES = vec2(float(INSCATTER_COLUMNS), ceil(float(INSCATTER_HEIGHTS) / float(INSCATTER_COLUMNS)));

// What a texel stands for: a view path and the sun's height above its base point's terminator plane [m] and cosine.
struct TablePath {
  Ray ray;
  float end;    // m, length of the path
  bool ground;  // where it ends
  vec2 sun;
};

// Texture coordinates of the two fetches, and the part of the second.
struct TableCell {
  vec2 low;
  vec2 high;
  float part;
};

#ifdef HAS_CURVED_MAPPING
const float SUN_SCALE = 0.97267627755;  // 1 - exp(-3.6)

float altitude_axis(float k) { return sqrt(clamp(k / u_top_k, 0.0, 1.0)); }
float altitude_axis_k(float unit) { return unit * unit * u_top_k; }
float sun_axis(float mu_s) { return clamp((1.0 - exp(-2.8 * mu_s - 0.8)) / SUN_SCALE, 0.0, 1.0); }
float sun_of_axis(float unit) { return clamp((-log(1.0 - SUN_SCALE * unit) - 0.8) / 2.8, -1.0, 1.0); }
#else
float altitude_axis(float k) { return clamp(altitude_of(k) / u_thickness, 0.0, 1.0); }
float altitude_axis_k(float unit) { return unit * u_thickness * (2.0 * u_bottom_radius + unit * u_thickness); }
float sun_axis(float mu_s) { return clamp(0.5 + 0.5 * mu_s, 0.0, 1.0); }
float sun_of_axis(float unit) { return 2.0 * unit - 1.0; }
#endif

#ifdef HAS_AD_HOC_PHASE
// Elek's phase of molecules for the sum of all orders, eq. 15, per steradian; its mean is 1.12 of isotropic.
float ad_hoc_phase(float nu) { return (1.12 + 0.4 * nu) / 12.566370614; }
#endif

// Places 0..1 along height, view and sun of a point on a path.
vec3 inscatter_place(float k, float x, vec2 sun) {
  float r = u_bottom_radius + altitude_of(max(k, 0.0));
  return vec3(altitude_axis(k), clamp(0.5 + 0.5 * x / r, 0.0, 1.0), sun_axis(clamp(sun.x / r, -1.0, 1.0)));
}

vec2 slice_origin(float slice) {
  float row = floor((slice + 0.5) / TILES.x);
  return vec2(slice - row * TILES.x, row);
}

TableCell inscatter_at(float k, float x, vec2 sun, float tangent_k, bool ground) {
  vec3 place = inscatter_place(k, x, sun);
  vec2 inside = (0.5 + place.zy * (TILE - 1.0)) / TILE;
  float slice = place.x * float(INSCATTER_HEIGHTS - 1);
  float first = min(floor(slice), float(INSCATTER_HEIGHTS - 2));
  return TableCell((slice_origin(first) + inside) / TILES, (slice_origin(first + 1.0) + inside) / TILES, slice - first);
}

vec4 inscatter_fetch(sampler2D table, TableCell cell) {
  return mix(texture(table, cell.low), texture(table, cell.high), cell.part);
}

// The path at a place; the inverse of inscatter_place.
TablePath inscatter_path(vec3 place) {
  float k = altitude_axis_k(place.x);
  float r = u_bottom_radius + altitude_of(k);
  float mu = 2.0 * place.y - 1.0;
  float mu_s = sun_of_axis(place.z);
  float nu = mu * mu_s + u_sun_azimuth * safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s));
  float x = r * mu;
  Ray ray = Ray(x, k, k - x * x, 0.0, 0.0);
  ray.air = max(far_root(x, k - u_top_k, safe_sqrt(u_top_k - ray.tangent_k)), 0.0);
  float distance = ground_distance(ray);
  bool ground = distance >= 0.0;
  return TablePath(ray, ground ? distance : ray.air, ground, vec2(r * mu_s, nu));
}

// Slice, view and sun of a texel, each counted from 0.
ivec3 inscatter_index(ivec2 texel) {
  ivec2 tile = texel / ivec2(TILE);
  ivec2 inside = texel - tile * ivec2(TILE);
  return ivec3(min(tile.y * INSCATTER_COLUMNS + tile.x, INSCATTER_HEIGHTS - 1), inside.y, inside.x);
}

TablePath inscatter_texel(ivec2 texel) {
  return inscatter_path(vec3(inscatter_index(texel)) / (vec3(float(INSCATTER_HEIGHTS), TILE.yx) - 1.0));
}
