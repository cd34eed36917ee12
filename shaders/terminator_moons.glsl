// Moons before a sun whose disc the planet's limb hides in part: strip by strip, and not a product.
//
// Of a strip of the disc a moon hides an interval of the chord, and several moons the union of theirs. What passes is the
// share of the light above the horizon, limb-darkened and dimmed strip by strip, that no moon hides. The few strips are
// held to what the moons' tables say of the whole disc. Lengths on the disc are in radii of the sun, a strip lies at the
// height cos b. The twin is shadowatmo/terminator_moons.py.

#ifdef HAS_NO_AIR
#include "limb.glsl"
#include "visibility.glsl"
#else
#include "terminator.glsl"
#include "eclipse.glsl"
#endif

uniform float u_limb_darkening;
uniform int u_strip_count;  // no constant: unrolled, the strips would take a driver long to compile
uniform vec2 u_strip_rule[STRIP_RULE];  // nodes and weights over 0..1

const float LEAST_SHARE = 1.0e-4;  // of the disc's light: of less than that the strips know nothing

// Light of a chord from its middle to x.
float chord_light(float x, float half_chord) {
  float rest = safe_sqrt((half_chord - x) * (half_chord + x));
  float turned = half_chord * half_chord * atan(x, max(rest, 1.0e-20));
  return (1.0 - u_limb_darkening) * x + 0.5 * u_limb_darkening * (x * rest + turned);
}

// The moons' discs at a point p of the sun's frame: height above the sun's center, place to one side, radius.
void moons_before_disc(vec3 p, out vec3 discs[DISC_MOONS]) {
  vec2 up = dot(p.xy, p.xy) > 1.0 ? normalize(p.xy) : vec2(1.0, 0.0);
  int count = 0;
#ifdef HAS_NARROW_MOONS
  for (int i = 0; i < NARROW_MOONS; ++i) {
    vec4 moon = narrow_moon(p, i);
    discs[count++] = vec3(-moon.zw, moon.y) / moon.x;  // it is seen opposite to the point's way out of its shadow
  }
#endif
#ifdef HAS_WIDE_MOONS
  for (int i = 0; i < WIDE_MOONS; ++i) discs[count++] = wide_moon(p, i);
#endif
  for (int i = 0; i < DISC_MOONS; ++i) {
    discs[i].xy = vec2(dot(up, discs[i].xy), up.x * discs[i].y - up.y * discs[i].x);
  }
}

// Light of a strip that no moon hides, and all of it. Nothing is sorted: from every end of a hidden interval light is free
// up to where the next one begins.
vec2 strip_light(vec3 discs[DISC_MOONS], float height, float half_chord) {
  float whole = chord_light(half_chord, half_chord);
  vec2 hidden[DISC_MOONS];
  for (int i = 0; i < DISC_MOONS; ++i) {
    float offset = height - discs[i].x;
    float size = safe_sqrt((discs[i].z - offset) * (discs[i].z + offset));
    vec2 ends = clamp(discs[i].y + vec2(-size, size), -half_chord, half_chord);
    hidden[i] = vec2(chord_light(ends.x, half_chord), chord_light(ends.y, half_chord));
  }
  float free = 0.0;
  for (int j = -1; j < DISC_MOONS; ++j) {
    if (j >= 0 && hidden[max(j, 0)].x >= hidden[max(j, 0)].y) continue;
    float from = j < 0 ? -whole : hidden[max(j, 0)].y;
    float to = whole;
    for (int i = 0; i < DISC_MOONS; ++i) {
      if (i == j || hidden[i].x >= hidden[i].y) continue;
      // of two that end at the same place the first one goes on
      bool covers = hidden[i].x <= from && (from < hidden[i].y || (i < j && from == hidden[i].y));
      to = covers ? from : (hidden[i].x > from ? min(to, hidden[i].x) : to);
    }
    free += to - from;
  }
  return vec2(free, 2.0 * whole);
}

// Fraction (3 channels) of the light of the disc above the limb that passes moons and rings. p = the point in the sun's
// frame, visible = visibility_at(p), k and y = those of the point, incidence = cosine on a plane and its change with the
// angle upward, or (1, 0).
vec3 disc_visibility(vec3 p, float visible, float k, float y, vec2 incidence) {
  if (visible <= 0.0 || visible >= 1.0) return vec3(visible);
  vec3 discs[DISC_MOONS];
  moons_before_disc(p, discs);
  Disc disc = disc_above_horizon(k, y);
  float rise = sqrt(disc.visible);
  float last = 2.0 * atan(rise, disc.root);  // b of the horizon, and what is left of half a turn below it
  float rest = 2.0 * atan(disc.root, rise);
  vec3 passing = vec3(0.0);
  vec3 light = vec3(1.0e-30);
  vec2 all = vec2(0.0);  // of the whole disc without air
  for (int i = 0; i < u_strip_count; ++i) {
    float b = last * u_strip_rule[i].x;
    float angle = u_sun_angle * cos(b);
    float square = angle * angle;
    float height = disc.height * (1.0 - square * (0.5 - square / 24.0)) + disc.across * angle * (1.0 - square / 6.0);
    vec2 strip = u_strip_rule[i].y * last * sin(b) * strip_light(discs, cos(b), sin(b));
#ifdef HAS_NO_AIR
    vec3 air = vec3(1.0);
#else
    vec3 air = max(incidence.x + angle * incidence.y, 0.0) * transmittance_to_top(k, height);
#endif
    passing += strip.x * air;
    light += strip.y * air;
    float below = rest * u_strip_rule[i].x;
    all += strip + u_strip_rule[i].y * rest * sin(below) * strip_light(discs, -cos(below), sin(below));
  }
  return clamp(visible * (passing / light + LEAST_SHARE) / (all.x / all.y + LEAST_SHARE), 0.0, 1.0);
}

#ifndef HAS_NO_AIR
// The same at the distance t [m] along a ray, for light in the air.
vec3 disc_visibility_along(float t, float k, float y) {
  vec3 p = eclipse_base * u_sun_axes + t * (eclipse_direction * u_sun_axes);
  return disc_visibility(p, visibility_at(p), k, y, vec2(1.0, 0.0));
}
#endif
