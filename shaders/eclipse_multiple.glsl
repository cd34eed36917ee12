// Light scattered more than once under the moons' shadows: ratios to the air without them, one small volume for a moon.
//
// A volume is an atlas: a tile for each coefficient across, the slices of altitude up, in a tile the distance from the
// shadow's axis across and the angle about it up. Tile 0 holds R, the last the ground's; a block of rows for each moon.
// Twin: shadowatmo/eclipse_multiple.py.

#include "eclipse.glsl"
#include "multiple.glsl"
#include "shade.glsl"

uniform sampler2D u_ratio;
uniform mat3 u_ratio_axes[OCCLUDERS];       // from planet-centered coordinates to the shadow's frame
uniform vec4 u_ratio_rings[OCCLUDERS];      // edge [m], 1 / width [1/m], arcsinh at the center, 1 / its span
uniform float u_ratio_squeeze[OCCLUDERS];
uniform float u_ratio_moments[RATIO_DEGREE + 1];  // Legendre moments of the aerosols' phase function

const int RATIO_COSINES = (RATIO_DEGREE + 1) * (RATIO_DEGREE + 2) / 2;
const int RATIO_COEFFICIENTS = (RATIO_DEGREE + 1) * (RATIO_DEGREE + 1);
const float RATIO_NORMS[RATIO_COSINES] = RATIO_NORM_VALUES;
const vec2 RATIO_TILE = vec2(float(RATIO_RINGS), float(RATIO_SECTORS));
const vec2 RATIO_SIZE = RATIO_TILE * vec2(float(RATIO_COEFFICIENTS + 1), float(RATIO_HEIGHTS * OCCLUDERS));
const float MEAN_TO_MOMENT = 3.54490770181103;  // the zeroth moment of a mean radiance

struct RatioPlace {
  vec2 texel;  // in the lower slice's tile 0
  float part;  // of the upper slice
  float side;  // sign of a coefficient that is odd across the plane of symmetry
  vec3 up;     // of the point, in the frame
  int moon;
};

RatioPlace ratio_place(vec3 up, float altitude, int moon) {
  vec3 u = u_ratio_axes[moon] * up;
  vec2 b = vec2(u.x * u_ratio_squeeze[moon], u.y) * sqrt(2.0 / max(1.0 + u.z, 1.0e-4));
  float rho = length(b);
  vec4 rings = u_ratio_rings[moon];
  float z = (u_bottom_radius * rho - rings.x) * rings.y;
  float stretched = log(abs(z) + sqrt(z * z + 1.0));
  float ring = clamp(((z < 0.0 ? -stretched : stretched) - rings.z) * rings.w, 0.0, 1.0);
  float sector = angle_over_pi(clamp(b.x / max(rho, 1.0e-20), -1.0, 1.0));
  float slice = height_coordinate(altitude) * float(RATIO_HEIGHTS - 1);
  float low = min(floor(slice), float(RATIO_HEIGHTS - 2));
  vec2 texel = 0.5 + vec2(ring, sector) * (RATIO_TILE - 1.0);
  texel.y += (float(moon * RATIO_HEIGHTS) + low) * RATIO_TILE.y;
  return RatioPlace(texel, slice - low, b.y < 0.0 ? -1.0 : 1.0, u, moon);
}

vec3 ratio_value(RatioPlace place, int tile) {
  vec2 at = (place.texel + vec2(float(tile) * RATIO_TILE.x, 0.0)) / RATIO_SIZE;
  vec3 low = texture(u_ratio, at).rgb;
  return mix(low, texture(u_ratio, at + vec2(0.0, RATIO_TILE.y / RATIO_SIZE.y)).rgb, place.part);
}

// What the moon changes in the source's shape, over the mean radiance: for molecules and for aerosols.
void ratio_shape(RatioPlace place, vec3 direction, out vec3 molecules, out vec3 aerosols) {
  vec3 v = u_ratio_axes[place.moon] * direction;
  vec3 s = place.up + vec3(0.0, 0.0, 1.0);
  vec3 turned = v - dot(v, s) / max(s.z, 1.0e-4) * s + vec3(0.0, 0.0, 2.0 * dot(v, place.up));
  molecules = vec3(0.0);
  aerosols = vec3(0.0);
  vec2 turn = vec2(1.0, 0.0);  // cosine and sine of m azimuths, times sine^m
  float first = 1.0;
  int index = 0;
  for (int m = 0; m <= RATIO_DEGREE; ++m) {
    float before = 0.0;
    float current = first;
    for (int l = m; l <= RATIO_DEGREE; ++l) {
      if (l > m) {
        float after = (float(2 * l - 1) * turned.z * current - float(l + m - 1) * before) / float(l - m);
        before = current;
        current = after;
      }
      if (l > 0 && l <= RATIO_TERMS) {
        vec3 value = turn.x * ratio_value(place, index);
        if (m > 0) value += place.side * turn.y * ratio_value(place, RATIO_COSINES + index - (RATIO_DEGREE + 1));
        value *= RATIO_NORMS[index] * current;
        aerosols += u_ratio_moments[l] * value;
        if (l == 2) molecules += 0.1 * value;
      }
      ++index;
    }
    turn = vec2(turn.x * turned.x - turn.y * turned.y, turn.x * turned.y + turn.y * turned.x);
    first *= float(2 * m + 1);
  }
}

// The source under one moon from the one without it, which a moon can only lessen; step = densities as it has them, mean = mean radiance [1/sr].
vec3 source_under(vec3 source, vec3 mean, vec2 step, vec3 point, vec3 direction, float altitude, int moon, float visible) {
  RatioPlace place = ratio_place(point / (u_bottom_radius + altitude), altitude, moon);
  vec3 molecules, aerosols;
  ratio_shape(place, direction, molecules, aerosols);
  vec3 change = step.x * u_rayleigh_scattering * molecules + step.y * u_mie_scattering * aerosols;
  vec3 ratio = shade(visible) * exp(ratio_value(place, 0));
  return min(ratio * max(source + MEAN_TO_MOMENT * mean * change, 0.0), source);
}

// Skylight on the ground under one moon over that without it.
vec3 ground_ratio_under(vec3 up, int moon, float visible) {
  return min(shade(visible) * exp(ratio_value(ratio_place(up, 0.0, moon), RATIO_COEFFICIENTS)), 1.0);
}

#ifdef HAS_MOON_SUM
// What several moons leave, from what each alone does: they add up as far as their discs do not overlap on the sun. Where
// they do, or where little is left and differences mean nothing, the remainders over shade() multiply: that of the moon
// that hides most, and of the others as much as they hide besides.
struct MoonSum {
  vec3 sum;
  vec3 remainders;  // their logarithms
  vec3 leading;     // those weighted by `weight`
  float hidden;
  float most;       // what is hidden, weighted
  float weight;
};

const MoonSum NO_MOONS = MoonSum(vec3(1.0), vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);

void add_moon(vec3 ratio, float visible, inout MoonSum moons) {
  vec3 remainder = log(max(ratio / shade(visible), 1.0e-9));
  float hidden = 1.0 - visible;
  float square = hidden * hidden;
  float weight = square * square * square * square + 1.0e-30;
  moons.sum -= 1.0 - ratio;
  moons.remainders += remainder;
  moons.leading += weight * remainder;
  moons.hidden += hidden;
  moons.most += weight * hidden;
  moons.weight += weight;
}

vec3 moons_leave(MoonSum moons, float visible) {
  vec3 leading = moons.leading / moons.weight;
  float most = moons.most / moons.weight;
  float others = moons.hidden - most;
  float besides = others > 1.0e-6 ? clamp((1.0 - visible - most) / others, 0.0, 1.0) : 1.0;
  vec3 product = shade(visible) * exp(leading + besides * (moons.remainders - leading));
  float overlap = visible - 1.0 + moons.hidden;
  float weight = max(smoothstep(0.0, 0.02, overlap), 1.0 - smoothstep(0.02, 0.2, visible));
  return mix(max(moons.sum + overlap, 0.0), product, weight);
}
#endif

// Share of the light that passes all rings: wide against the paths of scattered light, they dim it where it is scattered.
float rings_leave(vec3 point) {
  float share = 1.0;
#ifdef HAS_RINGS
  for (int i = 0; i < RINGS; ++i) share *= ring_visibility(point * u_sun_axes, i);
#endif
  return share;
}

// The source under all moons and rings.
vec3 eclipsed_source(vec3 source, vec3 mean, vec2 step, vec3 point, vec3 direction, float altitude) {
  float rings = rings_leave(point);
#ifdef HAS_MOON_SUM
  MoonSum moons = NO_MOONS;
  for (int i = 0; i < OCCLUDERS; ++i) {
    float visible = visible_fraction(point, i);
    vec3 shaded = source_under(source, mean, step, point, direction, altitude, i, visible);
    add_moon(shaded / max(source, 1.0e-30), visible, moons);
  }
  return rings * source * moons_leave(moons, sun_visibility(point) / max(rings, 1.0e-6));
#else
  return rings * source_under(source, mean, step, point, direction, altitude, 0, visible_fraction(point, 0));
#endif
}

// Skylight on the ground under all moons and rings over that without them.
vec3 ground_ratio(vec3 up) {
  vec3 point = up * u_bottom_radius;
  float rings = rings_leave(point);
#ifdef HAS_MOON_SUM
  MoonSum moons = NO_MOONS;
  for (int i = 0; i < OCCLUDERS; ++i) {
    float visible = visible_fraction(point, i);
    add_moon(ground_ratio_under(up, i, visible), visible, moons);
  }
  return rings * moons_leave(moons, sun_visibility(point) / max(rings, 1.0e-6));
#else
  return rings * ground_ratio_under(up, 0, visible_fraction(point, 0));
#endif
}
