#version 330 core
// Which tiles may be interpolated between their corners, and by which shader the others are drawn.
//
// Refused are tiles whose corners differ in kind; that the horizon, the top's limb, the sun or the narrow part of a moon's
// shadow passes, which may hide between corners; whose second differences exceed the tolerance or cannot be taken, and
// whose logarithm bends otherwise than a parabola; whose drawn depth is not what the corners interpolate.

#include "adaptive.glsl"

uniform sampler2D u_light;
uniform sampler2D u_clear;
uniform float u_tolerance;
uniform vec2 u_peak;  // sine of an angle from the sun's light within which the sky peaks between corners; its side, 1 or -1
#ifdef HAS_SUN_DISC
uniform vec4 u_disc;  // unit vector from the camera to the sun, sine of the angle that its disc takes
#endif
#ifdef HAS_BACKGROUND
uniform sampler2D u_background;
#endif
#ifdef HAS_RINGS
uniform vec4 u_ring_planes[RINGS];   // unit normal, its product with the vector from the camera to the center [m]
uniform vec4 u_ring_centers[RINGS];  // m, from the camera; cosine of normal and sun
uniform vec2 u_ring_radii[RINGS];    // m
#endif
#ifdef HAS_ECLIPSE
uniform vec4 u_moon_off[OCCLUDERS];   // m: camera to shadow axis, perpendicular to it; place of the camera along it
uniform vec4 u_moon_axis[OCCLUDERS];  // unit vector away from the sun
uniform vec4 u_moon_cones[OCCLUDERS]; // penumbra: m, slope; umbra: m, slope
#endif

flat in float v_brightest;
layout(location = 0) out float out_kind;
// What adaptive_curved.vert bends the tile's sides by: second differences of the light's logarithm, and of the opacity.
layout(location = 1) out vec4 out_below;
layout(location = 2) out vec4 out_above;
layout(location = 3) out vec4 out_left;
layout(location = 4) out vec4 out_right;
#ifdef HAS_BACKGROUND
layout(location = 5) out vec4 out_clear_across;  // of the transmittance, the mean of two sides
layout(location = 6) out vec4 out_clear_up;
#endif

// Parts of the brightest sample: below the first errors are counted absolutely; down to the second a tile is bent rather
// than left straight where that is closer, for whoever stretches the night.
const float DARKEST = 1.0e-4;
const float FAINTEST = 1.0e-8;
const vec3 THIRD = vec3(1.0 / 3.0);

float brightest(vec3 v) { return max(v.r, max(v.g, v.b)); }

struct Bounds {
  float angle;  // rad, of the tile's corners from its middle, at most
  Ray ray;      // of its middle
  vec3 direction;
  float x;  // m, from the tangent point to the camera, along the ray
};

Bounds tile_bounds(Pixel pixel) {
  Bounds tile;
  vec2 reach = 0.5 * float(TILE_PIXELS) * u_pixel_to_screen;
  float offset = length(vec2(reach.x * length(u_axes[0]), reach.y * length(u_axes[1])));
  tile.angle = offset / max(pixel.stretch - offset, 1.0);
  tile.ray = pixel_ray(pixel);
  tile.direction = pixel.direction;
  tile.x = dot(u_position_dots, pixel.screen) / pixel.stretch;
  return tile;
}

// k of the middle's tangent point [m^2], and how much those of the tile's rays differ from it at most; nothing where they rise.
const vec2 RISES = vec2(1.0e30, 0.0);
vec2 tangent_points(Bounds tile, Pixel pixel) {
  float r = sqrt(max(u_bottom_radius * u_bottom_radius + u_camera_k, 0.0));
  float x = tile.x;
  if (x > r * tile.angle) return RISES;
  // impact parameters of the tile differ from its middle's by at most this
  float spread = tile.angle * (abs(x) + 0.5 * r * tile.angle);
#ifdef HAS_FAR_CAMERA
  float impact = length(u_moments * pixel.screen) / pixel.stretch;
  float tangent_k = (impact - u_bottom_radius) * (impact + u_bottom_radius);
#else
  float tangent_k = u_camera_k - x * x;
  float impact = sqrt(max(u_bottom_radius * u_bottom_radius + tangent_k, 0.0));
#endif
  return vec2(tangent_k, spread * (2.0 * impact + spread));
}

// Whether any ray of a tile on the horizon or the limb may meet the planet's shadow before it leaves the air.
bool near_shadow(Bounds tile, Pixel pixel) {
  float last = max(sqrt(u_top_k) - tile.x - tile.ray.start, 0.0);
  float margin = 2.0 * tile.angle * (last + tile.ray.start);
#ifdef HAS_TERMINATOR
  Cone wider = u_dusk;
#else
  Cone wider = u_shadow;
#endif
  wider.excess += margin;
  wider.near -= margin;
  vec2 shadow = cone_interval(pixel_axis_ray(pixel, tile.ray, u_shadow_axis), wider, 1.0);
  return shadow.x < last && shadow.y > 0.0;
}

bool within(Bounds tile, vec3 toward, float sine) {
  return dot(tile.direction, toward) > 0.0 && length(cross(tile.direction, toward)) < sine + tile.angle;
}

bool on_peak(Bounds tile) {
#ifdef HAS_SUN_DISC
  if (within(tile, u_disc.xyz, u_disc.w)) return true;
#endif
  return u_peak.x > 0.0 && within(tile, -u_peak.y * u_shadow_axis.direction, u_peak.x);
}

#ifdef HAS_ECLIPSE
// Whether a ray of the tile meets a part of a moon's shadow that is narrow against the tile.
bool on_narrow_shadow(Bounds tile) {
  float first = tile.ray.start;
  float ground = ground_distance(tile.ray);
  float last = first + (ground >= 0.0 ? ground : tile.ray.air);
  for (int i = 0; i < OCCLUDERS; ++i) {
    float along = dot(tile.direction, u_moon_axis[i].xyz);
    vec3 across = tile.direction - along * u_moon_axis[i].xyz;
    float nearest = clamp(dot(across, u_moon_off[i].xyz) / max(dot(across, across), 1.0e-12), first, last);
    for (int j = 0; j < 3; ++j) {
      float t = j == 0 ? first : (j == 1 ? nearest : last);
      float z = u_moon_off[i].w + t * along;
      float rho = length(t * across - u_moon_off[i].xyz);
      float wide = 2.0 * t * tile.angle;
      float penumbra = u_moon_cones[i].x + z * u_moon_cones[i].y;
      float umbra = abs(u_moon_cones[i].z - z * u_moon_cones[i].w);
      bool narrow = (rho < penumbra + wide && penumbra - umbra < 2.0 * wide) || (rho < umbra + wide && umbra < 2.0 * wide);
      if (narrow && z > -u_bottom_radius) return true;
    }
  }
  return false;
}
#endif

#ifdef HAS_RINGS
const int RING_POINTS = 5;

// The same of a ring's shadow: whether the path crosses one that is thinner than the tile is wide there.
bool on_narrow_ring(Bounds tile) {
  float ground = ground_distance(tile.ray);
  float length_in_air = max(ground >= 0.0 ? ground : tile.ray.air, 0.0);
  for (int i = 0; i < RINGS; ++i) {
    float slant = u_ring_centers[i].w;
    float least = 1.0e30;
    float most = 0.0;
    float wide = 0.0;
    for (int j = 0; j < RING_POINTS; ++j) {
      float t = tile.ray.start + length_in_air * float(j) / float(RING_POINTS - 1);
      float up = (u_ring_planes[i].w - t * dot(tile.direction, u_ring_planes[i].xyz)) / slant;  // towards the sun
      float rho = length(t * tile.direction - up * u_shadow_axis.direction - u_ring_centers[i].xyz);
      wide = max(wide, 2.0 * t * tile.angle / abs(slant));
      least = up > 0.0 ? min(least, rho) : least;
      most = up > 0.0 ? max(most, rho) : most;
    }
    vec2 radii = u_ring_radii[i];
    if (radii.y - radii.x < 2.0 * wide && most + wide > radii.x && least - wide < radii.y) return true;
  }
  return false;
}
#endif

// The samples at the corners, and beyond them to the left, to the right, below and above.
const ivec2 AROUND[12] = ivec2[12](
  ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1),
  ivec2(-1, 0), ivec2(-1, 1), ivec2(2, 0), ivec2(2, 1), ivec2(0, -1), ivec2(1, -1), ivec2(0, 2), ivec2(1, 2)
);
vec4 sample_light[12];
vec4 sample_clear[12];  // a: the code of the path, -1 outside of the grid

void fetch_samples(ivec2 at) {
  ivec2 last = textureSize(u_light, 0) - 1;
  for (int i = 0; i < 12; ++i) {
    ivec2 place = clamp(at + AROUND[i], ivec2(0), last);
    sample_light[i] = texelFetch(u_light, place, 0);
    sample_clear[i] = texelFetch(u_clear, place, 0);
    sample_clear[i].a = place == at + AROUND[i] ? sample_clear[i].a : -1.0;
  }
}

vec4 logarithm(vec4 light) { return vec4(log(max(light.rgb, 1.0e-30)), light.a); }

// Second differences at both ends of a side, of which those count whose neighbor beyond is of the same kind.
struct Side {
  float known;  // of the two
  vec4 light;   // the larger one
  vec4 clear;
  vec4 bend;    // of logarithms: the mean of both, or the known one; how far that may be off
  vec4 bend_doubt;
  vec4 clear_bend;
  vec4 clear_doubt;
};

// What parabolas leave, as second differences: by how far the two ends differ, or without one of them a share of the other.
const float BOTH_ENDS = 0.8;
const float ONE_END = 1.6;

vec4 doubt(vec2 known, vec4 first, vec4 second) {
  return known.x * known.y > 0.0 ? BOTH_ENDS * abs(second - first) : ONE_END * abs(known.x * first + known.y * second);
}

Side tile_side(int before, int start, int end, int after) {
  float code = sample_clear[0].a;
  vec2 known = vec2(sample_clear[before].a == code ? 1.0 : 0.0, sample_clear[after].a == code ? 1.0 : 0.0);
  vec2 share = known / max(known.x + known.y, 1.0);
  Side side;
  side.known = known.x + known.y;
  vec4 first = sample_light[before] - 2.0 * sample_light[start] + sample_light[end];
  vec4 second = sample_light[start] - 2.0 * sample_light[end] + sample_light[after];
  side.light = max(known.x * abs(first), known.y * abs(second));
  vec4 a = logarithm(sample_light[start]);
  vec4 b = logarithm(sample_light[end]);
  first = logarithm(sample_light[before]) - 2.0 * a + b;
  second = a - 2.0 * b + logarithm(sample_light[after]);
  side.bend = share.x * first + share.y * second;
  side.bend_doubt = doubt(known, first, second);
  side.clear = vec4(0.0);
  side.clear_bend = vec4(0.0);
  side.clear_doubt = vec4(0.0);
#ifdef HAS_BACKGROUND
  first = sample_clear[before] - 2.0 * sample_clear[start] + sample_clear[end];
  second = sample_clear[start] - 2.0 * sample_clear[end] + sample_clear[after];
  side.clear = max(known.x * abs(first), known.y * abs(second));
  a = logarithm(sample_clear[start]);
  b = logarithm(sample_clear[end]);
  first = logarithm(sample_clear[before]) - 2.0 * a + b;
  second = a - 2.0 * b + logarithm(sample_clear[after]);
  side.clear_bend = share.x * first + share.y * second;
  side.clear_doubt = doubt(known, first, second);
#endif
  return side;
}

#ifdef HAS_DRAWN_DEPTH
// Largest error of the path's last lit piece, relative to its length, by depth that the corners do not interpolate.
float depth_error(Bounds tile, Pixel pixel, vec2 number) {
  ivec2 texel = sample_texel(number);
  vec4 corners;
  for (int i = 0; i < 4; ++i) {
    vec2 corner = number + vec2(i & 1, i >> 1);
    corners[i] = 1.0 / drawn_distance(sample_texel(corner), make_pixel(sample_place(corner)));
  }
  float error = 0.0;
  float largest = 0.0;
  for (int y = 0; y < TILE_PIXELS; ++y) {
    for (int x = 0; x < TILE_PIXELS; ++x) {
      ivec2 place = min(texel + ivec2(x, y), u_size - 1);
      float inverse = 1.0 / drawn_distance(place, make_pixel(vec2(place) + 0.5));
      vec2 part = vec2(place - ivec2(number) * TILE_PIXELS) / float(TILE_PIXELS);
      vec2 sides = mix(corners.xz, corners.yw, part.x);
      float expected = mix(sides.x, sides.y, part.y);
      error = max(error, abs(inverse - expected) / max(max(inverse, expected), 1.0e-29));
      largest = max(largest, inverse);
    }
  }
  float distance = 1.0 / max(largest, 1.0e-29);
  float end = clamp(distance - tile.ray.start, 0.0, max(tile.ray.air, 0.0));
  vec2 shadow = clamp(shadow_along(min(texel, u_size - 1), pixel, tile.ray), 0.0, end);
  float piece = shadow.y > shadow.x && shadow.y < end ? end - shadow.y : end;
  return tile.ray.air < 0.0 || error == 0.0 ? error : error * distance / max(piece, 1.0e-3 * distance);
}
#endif

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec2 number = vec2(at);
  Pixel pixel = make_pixel(sample_place(number + 0.5));
  Bounds tile = tile_bounds(pixel);

  fetch_samples(at);
  vec3 lit = vec3(0.0);
  vec3 behind = vec3(0.0);
  vec3 passed = vec3(0.0);
  vec3 share = vec3(0.0);  // largest, of the light's channels in the pixel's brightest; of what passes the air
  vec3 passed_share = vec3(0.0);
  vec3 faint_share = vec3(0.0);  // both, where nothing is too dark to count
  float darkest = 1.0e30;
  float code = sample_clear[0].a;
  bool same = true;
  bool any_shadow = false;
  bool all_shadow = true;
  bool any_before = false;
  bool any_behind = false;
  for (int i = 0; i < 4; ++i) {
    vec4 through = sample_clear[i];
    vec3 radiance = sample_light[i].rgb;
    same = same && through.a == code;
    any_shadow = any_shadow || code_has(through.a, SHADOW_BEHIND);
    all_shadow = all_shadow && code_has(through.a, WITH_SHADOW) && code_has(through.a, WITH_GROUND) == code_has(code, WITH_GROUND);
    any_before = any_before || code_has(through.a, LIT_BEFORE);
    any_behind = any_behind || code_has(through.a, LIT_BEHIND);
    vec3 background = vec3(0.0);
#ifdef HAS_BACKGROUND
    background = abs(texelFetch(u_background, sample_texel(number + vec2(AROUND[i])), 0).rgb);
#endif
    float level = brightest(radiance + through.rgb * background);
    darkest = min(darkest, level);
    faint_share = max(faint_share, max(radiance, through.rgb * background) / max(max(level, FAINTEST * v_brightest), 1.0e-30));
    level = max(max(level, DARKEST * v_brightest), 1.0e-30);
    share = max(share, radiance / level);
    passed_share = max(passed_share, through.rgb * background / level);
    lit += 0.25 * radiance;
    passed += 0.25 * through.rgb;
    behind += 0.25 * background;
  }
  // Any ray may touch the ground's or the top's sphere without a corner telling.
  vec2 tangent = tangent_points(tile, pixel);
  bool edge = abs(tangent.x) < tangent.y || abs(tangent.x - u_top_k) < tangent.y;
  float pixel_level = max(darkest, DARKEST * v_brightest);
  Side below = tile_side(4, 0, 1, 6);
  Side above = tile_side(5, 2, 3, 7);
  Side left = tile_side(8, 0, 2, 10);
  Side right = tile_side(9, 1, 3, 11);
  // Beside an edge one of two neighbors is of another kind, and towards it the frame often bends the more.
  vec2 known = vec2(below.known + above.known, left.known + right.known);
  vec2 doubled = vec2(known.x < 4.0 ? 2.0 : 1.0, known.y < 4.0 ? 2.0 : 1.0);
  vec4 light = doubled.x * max(below.light, above.light) + doubled.y * max(left.light, right.light);
  vec3 error = light.rgb;
  float limit = 8.0 * u_tolerance;
#ifdef HAS_BACKGROUND
  error += (doubled.x * max(below.clear, above.clear) + doubled.y * max(left.clear, right.clear)).rgb * behind;
#endif
  float faint_level = max(darkest, FAINTEST * v_brightest);
  bool smooth_enough = brightest(error) <= limit * pixel_level && light.a <= limit && min(known.x, known.y) > 0.5;
  vec4 off = max(below.bend_doubt, above.bend_doubt) + max(left.bend_doubt, right.bend_doubt);
  vec3 curved_error = share * off.rgb;
#ifdef HAS_BACKGROUND
  vec4 clear_off = max(below.clear_doubt, above.clear_doubt) + max(left.clear_doubt, right.clear_doubt);
  clear_off += 0.5 * (abs(below.clear_bend - above.clear_bend) + abs(left.clear_bend - right.clear_bend));
  curved_error += passed_share * clear_off.rgb;
#endif
  float faint_error = brightest(error) / max(faint_level, 1.0e-30);
  bool bent = faint_error > limit && brightest(faint_share * off.rgb) < min(0.5 * faint_error, 1.0);
  float sides = min(min(below.known, above.known), min(left.known, right.known));
  bool curved = brightest(curved_error) <= limit && off.a <= limit && sides > 0.5;
  bool flat_enough = true;
#ifdef HAS_DRAWN_DEPTH
  vec3 weighed = lit - passed * log(max(passed, 1.0e-20)) * behind;
  float weight = min(brightest(weighed) / max(pixel_level, 1.0e-30), 1.0);
  flat_enough = depth_error(tile, pixel, number) * weight <= u_tolerance;
#endif
  bool refused = !same || edge || on_peak(tile) || !flat_enough;
#ifdef HAS_ECLIPSE
  refused = refused || on_narrow_shadow(tile);
#endif
#ifdef HAS_RINGS
  refused = refused || on_narrow_ring(tile);
#endif
  // Between paths that are dark at one and the same end, or all along, there is none with two lit pieces.
  bool one_kind = (same || all_shadow) && flat_enough && !edge && !(any_before && any_behind);
  bool lit_alone = !any_shadow && !(edge && near_shadow(tile, pixel));
#ifdef HAS_LONG_PATHS
  lit_alone = lit_alone && (tangent.x < -tangent.y || tangent.x > DENSEST * u_top_k);
#endif
  float kind = lit_alone ? LIT_TILE : (one_kind ? SHADOW_TILE : MIXED_TILE);
  bool straight = smooth_enough && !(curved && bent);
  out_kind = refused || !(straight || curved) ? kind : (straight ? INTERPOLATED : CURVED_TILE);
  out_below = below.bend;
  out_above = above.bend;
  out_left = left.bend;
  out_right = right.bend;
#ifdef HAS_BACKGROUND
  out_clear_across = 0.5 * (below.clear_bend + above.clear_bend);
  out_clear_up = 0.5 * (left.clear_bend + right.clear_bend);
#endif
}
