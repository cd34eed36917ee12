#version 330 core
// Which tiles may be interpolated between their corners, and by which shader the others are drawn.
//
// Refused are tiles whose corners differ in kind; that the horizon, the top's limb, the sun or the narrow part of a moon's
// shadow passes, which may hide between corners; whose second differences exceed the tolerance or cannot be taken; whose
// drawn depth is not what the corners interpolate.

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
out float out_kind;

const float DARKEST = 1.0e-4;  // of the brightest sample, below which errors are counted absolutely
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

// Whether a ray of the tile may touch the ground's or the top's sphere without any corner telling.
bool on_limb(Bounds tile, Pixel pixel) {
  float r = sqrt(max(u_bottom_radius * u_bottom_radius + u_camera_k, 0.0));
  float x = tile.x;
  if (x > r * tile.angle) return false;
  // impact parameters of the tile differ from its middle's by at most this
  float spread = tile.angle * (abs(x) + 0.5 * r * tile.angle);
#ifdef HAS_FAR_CAMERA
  float impact = length(u_moments * pixel.screen) / pixel.stretch;
  float tangent_k = (impact - u_bottom_radius) * (impact + u_bottom_radius);
#else
  float tangent_k = u_camera_k - x * x;
  float impact = sqrt(max(u_bottom_radius * u_bottom_radius + tangent_k, 0.0));
#endif
  spread *= 2.0 * impact + spread;
  return abs(tangent_k) < spread || abs(tangent_k - u_top_k) < spread;
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

// Second differences of light and transmittance about a sample, where both neighbors are of the same kind; a: how many.
void bend(ivec2 at, ivec2 step, float code, inout vec4 light, inout vec4 clear) {
  ivec2 last = textureSize(u_light, 0) - 1;
  ivec2 before = max(at - step, 0);
  ivec2 after = min(at + step, last);
  vec4 here = texelFetch(u_clear, at, 0);
  vec4 left = texelFetch(u_clear, before, 0);
  vec4 right = texelFetch(u_clear, after, 0);
  bool known = left.a == code && right.a == code && before != at && after != at;
  vec4 bent = texelFetch(u_light, before, 0) - 2.0 * texelFetch(u_light, at, 0) + texelFetch(u_light, after, 0);
  light = known ? max(light, abs(bent)) : light;
  clear = known ? vec4(max(clear.rgb, abs(left.rgb - 2.0 * here.rgb + right.rgb)), clear.a + 1.0) : clear;
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

  vec4 light = vec4(0.0);  // second differences, across and up
  vec4 clear = vec4(0.0);
  vec4 light_up = vec4(0.0);
  vec4 clear_up = vec4(0.0);
  vec3 lit = vec3(0.0);
  vec3 behind = vec3(0.0);
  vec3 passed = vec3(0.0);
  float darkest = 1.0e30;
  float code = texelFetch(u_clear, at, 0).a;
  bool same = true;
  bool any_shadow = false;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = at + ivec2(i & 1, i >> 1);
    vec4 through = texelFetch(u_clear, corner, 0);
    vec3 radiance = texelFetch(u_light, corner, 0).rgb;
    same = same && through.a == code;
    any_shadow = any_shadow || code_has(through.a, SHADOW_BEHIND);
    vec3 background = vec3(0.0);
#ifdef HAS_BACKGROUND
    background = abs(texelFetch(u_background, sample_texel(vec2(corner)), 0).rgb);
#endif
    darkest = min(darkest, brightest(radiance + through.rgb * background));
    lit += 0.25 * radiance;
    passed += 0.25 * through.rgb;
    behind += 0.25 * background;
    bend(corner, ivec2(1, 0), code, light, clear);
    bend(corner, ivec2(0, 1), code, light_up, clear_up);
  }
  bool edge = on_limb(tile, pixel);
  float pixel_level = max(darkest, DARKEST * v_brightest);
  // Beside an edge one of two neighbors is of another kind, and towards it the frame often bends the more.
  float doubt = clear.a < 4.0 ? 2.0 : 1.0;
  float doubt_up = clear_up.a < 4.0 ? 2.0 : 1.0;
  light = doubt * light + doubt_up * light_up;
  vec3 error = light.rgb;
  float limit = 8.0 * u_tolerance;
#ifdef HAS_BACKGROUND
  error += (doubt * clear.rgb + doubt_up * clear_up.rgb) * behind;
#endif
  bool smooth_enough = brightest(error) <= limit * pixel_level && light.a <= limit && min(clear.a, clear_up.a) > 0.5;
  bool flat_enough = true;
#ifdef HAS_DRAWN_DEPTH
  vec3 share = lit - passed * log(max(passed, 1.0e-20)) * behind;
  float weight = min(brightest(share) / max(pixel_level, 1.0e-30), 1.0);
  flat_enough = depth_error(tile, pixel, number) * weight <= u_tolerance;
#endif
  bool refused = !same || edge || on_peak(tile) || !smooth_enough || !flat_enough;
#ifdef HAS_ECLIPSE
  refused = refused || on_narrow_shadow(tile);
#endif
#ifdef HAS_RINGS
  refused = refused || on_narrow_ring(tile);
#endif
  bool one_kind = same && flat_enough && !edge;
  bool two_pieces = code_has(code, LIT_BEFORE) && code_has(code, LIT_BEHIND);
  bool lit_alone = !any_shadow && !(edge && near_shadow(tile, pixel));
  float kind = lit_alone ? LIT_TILE : (one_kind && !two_pieces ? SHADOW_TILE : MIXED_TILE);
  out_kind = refused ? kind : INTERPOLATED;
}
