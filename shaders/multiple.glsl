// Lookup of multiple scattering: the source of all orders from the second on, and skylight on the ground.
//
// What molecules scatter has degree 2 in the view's direction: the logarithm of the mean radiance and three coefficients
// over it, at many places over sun and altitude, three bilinear fetches. What aerosols scatter is an atlas: a tile for each
// view direction (mu across, azimuth from the sun up), inside a tile mu_s across and altitude up, as far as there are
// aerosols, four bilinear fetches. It holds the source over scattering coefficient and mean radiance, because the mean
// spans ten decades where the source's shape does not. What the forward lobe has above the table's degree is analytic, see
// aureole_source. Twin: shadowatmo/multiple.py.

#include "medium.glsl"
#include "phase.glsl"
#include "ray.glsl"

uniform vec3 u_sun_mapping;    // width about the horizon, arcsinh of the elevation over it at the low end, its span
uniform float u_highest_layer;  // place of the atlas's last altitude among all

// Places 0..1 along the table's axes, and their inverses. The sun's goes by a stand-in for its elevation that is mu_s about
// the horizon and uniform in the angle about the zenith.
float sun_coordinate(float mu_s) {
  float z = 2.0 * mu_s / (u_sun_mapping.x * (1.0 + safe_sqrt(1.0 - abs(mu_s))));
  float stretched = log(abs(z) + sqrt(z * z + 1.0));
  return clamp(((z < 0.0 ? -stretched : stretched) - u_sun_mapping.y) / u_sun_mapping.z, 0.0, 1.0);
}
float sun_height(float unit) {
  float e = exp(u_sun_mapping.y + u_sun_mapping.z * unit);
  float elevation = 0.5 * u_sun_mapping.x * (e - 1.0 / e);
  return elevation - 0.25 * elevation * abs(elevation);
}
float height_coordinate(float altitude) { return sqrt(clamp(altitude / u_thickness, 0.0, 1.0)); }
float height_of(float unit) { return u_thickness * unit * unit; }

// acos(c) / pi for c in -1..1, after Abramowitz and Stegun 4.4.45: absolute error 2e-5.
float angle_over_pi(float c) {
  float a = abs(c);
  float angle = sqrt(1.0 - a) * (0.5 - a * (0.0675181 - a * (0.0236380 - a * 0.0059617)));
  return c < 0.0 ? 1.0 - angle : angle;
}
float azimuth_cosine(float mu, float mu_s, float nu) {
  float across = max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 1.0e-12);
  return clamp((nu - mu * mu_s) * inversesqrt(across), -1.0, 1.0);
}
float azimuth_coordinate(float c) { return sqrt(0.5 - 0.5 * c); }  // sine of half the azimuth: dense before the sun

#ifdef HAS_MULTIPLE
uniform sampler2D u_multiple_table;
uniform sampler2D u_multiple_level;
uniform sampler2D u_ground_irradiance;
uniform sampler2D u_aureole_table;

const vec2 TILE = vec2(float(MULTIPLE_SUNS), float(MULTIPLE_LAYERS));
const vec2 LEVEL = vec2(MULTIPLE_FINER * (MULTIPLE_SUNS - 1) + 1, MULTIPLE_FINER_HEIGHTS * (MULTIPLE_HEIGHTS - 1) + 1);
const float LEVEL_PARTS = 3.0;  // the logarithm of the mean, coefficients for m = 0 and 1; those for 2 in the alphas
const vec2 TILES = vec2(float(MULTIPLE_POLAR), float(MULTIPLE_AZIMUTHS));

vec4 level_part(vec2 unit, float part) {
  return texture(u_multiple_level, vec2(0.0, part / LEVEL_PARTS) + (0.5 + unit * (LEVEL - 1.0)) / (LEVEL * vec2(1.0, LEVEL_PARTS)));
}

// Source [1/sr times the unit of the coefficients] of the scattering coefficients of molecules and aerosols.
vec3 multiple_source(vec3 rayleigh, vec3 mie, float altitude, float mu_s, float mu, float nu) {
  // between the centers of the first and last texel, so that no tile reaches into the next
  vec2 unit = vec2(sun_coordinate(mu_s), height_coordinate(altitude));
  vec4 level = level_part(unit, 0.0);
  vec4 first = level_part(unit, 1.0);
  vec4 second = level_part(unit, 2.0);
  float c = azimuth_cosine(mu, mu_s, nu);
  float s = safe_sqrt(1.0 - mu * mu);
  vec3 molecules = 1.0 + (1.5 * mu * mu - 0.5) * first.rgb + mu * s * c * second.rgb;
  molecules += s * s * (2.0 * c * c - 1.0) * vec3(level.a, first.a, second.a);

  vec2 inside = 0.5 + vec2(unit.x, min(unit.y / u_highest_layer, 1.0)) * (TILE - 1.0);
  vec2 place = vec2(1.0 - angle_over_pi(clamp(mu, -1.0, 1.0)), azimuth_coordinate(c)) * (TILES - 1.0);
  vec2 cell = min(floor(place), TILES - 2.0);
  vec2 part = place - cell;
  vec2 corner = (cell * TILE + inside) / (TILE * TILES);
  vec2 next = 1.0 / TILES;
  vec3 low = mix(texture(u_multiple_table, corner).rgb, texture(u_multiple_table, corner + vec2(next.x, 0.0)).rgb, part.x);
  vec3 high = mix(texture(u_multiple_table, corner + vec2(0.0, next.y)).rgb, texture(u_multiple_table, corner + next).rgb, part.x);
  return exp(level.rgb) * (rayleigh * molecules + mie * mix(low, high, part.y));
}

// The mean radiance [1/sr] over directions that goes with it.
vec3 multiple_mean(float altitude, float mu_s) {
  return exp(level_part(vec2(sun_coordinate(mu_s), height_coordinate(altitude)), 0.0).rgb);
}

// Irradiance of the ground by the sky, all orders from the first on, per unit solar irradiance.
vec3 ground_irradiance(float mu_s) {
  float texel = 0.5 + sun_coordinate(mu_s) * (LEVEL.x - 1.0);
  return exp(texture(u_ground_irradiance, vec2(texel / LEVEL.x, 0.5)).rgb);
}

// The three sums over the forward lobe's high degrees, once per ray: nu is constant along it.
vec3 aureole_kernel(float nu) {
  float texel = 0.5 + sqrt(clamp(0.5 - 0.5 * nu, 0.0, 1.0)) * float(AUREOLE_TEXELS - 1);
  return texture(u_aureole_table, vec2(texel / float(AUREOLE_TEXELS), 0.5)).rgb;
}

// Source [1/m 1/sr] of those degrees at a lit point: density of aerosols, transmittance to the sun, and the column of
// aerosols [m] towards it. Fades out below the horizon, where the small-angle limit fails.
vec3 aureole_source(float density, float mu_s, vec3 light, float sun_column, vec3 kernel) {
  vec3 tau = u_mie_scattering * sun_column;
  vec3 series = kernel.x + tau * (kernel.y / 2.0 + tau * kernel.z / 6.0);
  return clamp(0.5 + mu_s / 0.3, 0.0, 1.0) * density * u_mie_scattering * light * tau * series;
}
#endif
