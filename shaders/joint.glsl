// Light of a limb-darkened disc that several discs hide together: Green's theorem along the edge of their union.
//
// Lengths in radii of the sun, its center is the origin; a disc is (x, y, k). On the edge of a disc what counts lies
// before the sun and in no other disc: from every end of a covered arc on to where the next one begins, so nothing is
// sorted. The field whose curl is the intensity 1 - u (1 - sqrt(1 - r^2)) runs around the center. Angles on a disc's
// edge count from its point nearest to the center, where a large disc's edge has all of its part in the matter.

uniform float u_limb_darkening;
uniform int u_disc_count;  // no constant: unrolled, eight discs would take a driver many seconds to compile

const float HALF_TURN = 3.14159265359;
const float SAME = 1.0e-6;  // turns; of two ends closer than this the first disc's counts
const float ARC_NODES[ARC_NODE_COUNT] = ARC_NODE_VALUES;
const float ARC_WEIGHTS[ARC_NODE_COUNT] = ARC_WEIGHT_VALUES;

// Half of an angle given by squares of the sides of its half-angle triangle.
float half_angle(float opposite, float adjacent) {
  float low = max(adjacent, 0.0);
  return opposite <= 0.0 ? 0.0 : 2.0 * atan(sqrt(opposite), sqrt(low));
}

// The field over r, from r^2: regular at 0.
float circulation(float square) {
  float root = sqrt(clamp(1.0 - square, 0.0, 1.0));
  return 0.5 * (1.0 - u_limb_darkening) + u_limb_darkening * (1.0 + root + root * root) / (3.0 * (1.0 + root));
}

// Sine for |x| <= pi/2 with the relative error of a float, which the builtin need not have.
float small_sine(float x) {
  float s = x * x;
  return x * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s / 362880.0))));
}

// Light that a stretch of a disc's edge contributes.
float edge_light(float delta, float k, float start, float width) {
  float light = 0.0;
  for (int n = 0; n < ARC_NODE_COUNT; ++n) {
    float sine = small_sine(0.5 * (start + width * ARC_NODES[n]));
    float lift = sine * sine;
    float square = (delta - k) * (delta - k) + 4.0 * delta * k * lift;
    light += ARC_WEIGHTS[n] * circulation(square) * ((k - delta) + 2.0 * delta * lift);
  }
  return light * width * k;
}

// Half of the edge of a disc that lies before the sun, as an angle, and half of the sun's limb that lies behind it.
vec2 limb_angles(float delta, float k) {
  float within = (1.0 - delta + k) * (1.0 + delta - k);
  float outside = (delta + k - 1.0) * (delta + k + 1.0);
  float behind = (k - 1.0 + delta) * (k + 1.0 - delta);
  float rest = (1.0 + delta - k) * (1.0 + delta + k);
  bool covers = k >= 1.0 + delta;
  return vec2(covers ? 0.0 : half_angle(within, outside), covers ? HALF_TURN : half_angle(behind, rest));
}

float all_light() { return HALF_TURN * (1.0 - u_limb_darkening / 3.0); }

// Fraction of the light that one disc hides.
float hidden_by_one(vec3 disc) {
  float delta = length(disc.xy);
  vec2 angles = limb_angles(delta, disc.z);
  float light = 2.0 * (edge_light(delta, disc.z, 0.0, angles.x) + angles.y * circulation(1.0));
  return clamp(light / all_light(), 0.0, 1.0);
}

// How far from `from` [turns] to the next of the arcs (start, width); 0 inside one. `own` is the arc that ends there.
float free_stretch(float from, vec2 arcs[MAX_DISCS], int own, float reach) {
  float stretch = reach;
  for (int j = 0; j < u_disc_count; ++j) {
    if (arcs[j].y <= 0.0) continue;
    float place = fract(from - arcs[j].x);
    bool inside = j != own && place < arcs[j].y + (j < own ? SAME : -SAME);
    stretch = min(stretch, inside || arcs[j].y >= 1.0 ? 0.0 : 1.0 - place);
  }
  return stretch;
}

// The arcs [turns] that the other discs cover of the edge of disc i, from its point nearest to the sun's center.
void cover_edge(vec3 discs[MAX_DISCS], int i, vec2 facing, out vec2 arcs[MAX_DISCS]) {
  float k = discs[i].z;
  for (int j = 0; j < u_disc_count; ++j) {
    vec2 apart = discs[j].xy - discs[i].xy;
    float d = length(apart);
    float other = discs[j].z * (j < i ? 1.0 + 3.0e-7 : 1.0 - 3.0e-7);  // of equal discs the first one counts
    float reach = (other - d + k) * (other + d - k);
    bool covers = other >= d + k;
    float angle = covers ? HALF_TURN : half_angle(reach, (d + k - other) * (d + k + other));
    float middle = d > 0.0 ? atan(facing.x * apart.y - facing.y * apart.x, dot(facing, apart)) : 0.0;
    arcs[j] = j == i ? vec2(0.0) : vec2(middle - angle, 2.0 * angle) / (2.0 * HALF_TURN);
  }
}

// Light at the edge of disc i, before the sun and in no other disc.
float exposed_edge(vec3 discs[MAX_DISCS], int i) {
  float delta = length(discs[i].xy);
  float before_sun = limb_angles(delta, discs[i].z).x;
  if (before_sun <= 0.0) return 0.0;
  vec2 facing = delta > 0.0 ? -discs[i].xy / delta : vec2(1.0, 0.0);
  vec2 arcs[MAX_DISCS];
  cover_edge(discs, i, facing, arcs);
  float light = 0.0;
  for (int j = 0; j < u_disc_count; ++j) {
    // The disc's own place stands for the stretch that begins at the sun's limb.
    float turn = j == i ? -before_sun / (2.0 * HALF_TURN) : arcs[j].x + arcs[j].y;
    turn -= j == i ? 0.0 : floor(turn + 0.5);
    float start = 2.0 * HALF_TURN * turn;
    bool inside = start < before_sun && start > 2.0 * HALF_TURN * SAME - before_sun;
    bool begins = j == i || (arcs[j].y > 0.0 && inside);
    float reach = (before_sun - start) / (2.0 * HALF_TURN);
    float stretch = begins ? free_stretch(turn, arcs, j == i ? -1 : j, reach) : 0.0;
    if (stretch > 0.0) light += edge_light(delta, discs[i].z, start, 2.0 * HALF_TURN * stretch);
  }
  return light;
}

// Length [rad] of the sun's limb that some disc hides.
float hidden_limb(vec3 discs[MAX_DISCS]) {
  vec2 arcs[MAX_DISCS];
  bool any_arc = false;
  for (int j = 0; j < u_disc_count; ++j) {
    float angle = limb_angles(length(discs[j].xy), discs[j].z).y;
    float middle = dot(discs[j].xy, discs[j].xy) > 0.0 ? atan(discs[j].y, discs[j].x) : 0.0;
    arcs[j] = vec2(middle - angle, 2.0 * angle) / (2.0 * HALF_TURN);
    any_arc = any_arc || angle > 0.0;
  }
  float free_turns = any_arc ? 0.0 : 1.0;
  for (int j = 0; j < u_disc_count; ++j) {
    if (arcs[j].y > 0.0) free_turns += free_stretch(arcs[j].x + arcs[j].y, arcs, j, 1.0);
  }
  return 2.0 * HALF_TURN * (1.0 - free_turns);
}

// Fraction of the sun's light that the discs hide together.
float hidden_by_all(vec3 discs[MAX_DISCS]) {
  float light = hidden_limb(discs) * circulation(1.0);
  for (int i = 0; i < u_disc_count; ++i) light += exposed_edge(discs, i);
  return clamp(light / all_light(), 0.0, 1.0);
}
