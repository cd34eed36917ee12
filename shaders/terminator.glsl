// The light of a sun whose disc the planet's limb hides in part: the mean over the strips of the disc above the horizon.
//
// The disc is planar, uniform, and told by zenith angles alone. A strip at the height y, -1 to 1 in radii of the disc, has
// the weight (2/pi) sqrt(1 - y^2) dy. With q the part of the diameter above the horizon, y = 1 - 2 q v, and v runs over
// the nodes of the Gauss rule of that weight on the visible part. Nodes, and weights over q^(3/2), are polynomials of
// sqrt(1 - q) that shadowatmo/terminator.py fits. What a moon leaves of that part: terminator_moons.glsl.

#include "transmittance.glsl"
#include "limb.glsl"

const float STRIP_NODES[4 * STRIPS] = STRIP_NODE_VALUES;  // by powers, strip by strip
const float STRIP_WEIGHTS[4 * STRIPS] = STRIP_WEIGHT_VALUES;

// Height r cos(theta) [m] and weight of a strip; its angle above the center comes out too.
vec2 disc_strip(Disc disc, int index, out float angle) {
  int i = 4 * index;
  float c = disc.root;
  float v = STRIP_NODES[i] + c * (STRIP_NODES[i + 1] + c * (STRIP_NODES[i + 2] + c * STRIP_NODES[i + 3]));
  float w = STRIP_WEIGHTS[i] + c * (STRIP_WEIGHTS[i + 1] + c * (STRIP_WEIGHTS[i + 2] + c * STRIP_WEIGHTS[i + 3]));
  angle = u_sun_angle * (1.0 - 2.0 * disc.visible * v);
  float square = angle * angle;
  float height = disc.height * (1.0 - square * (0.5 - square / 24.0)) + disc.across * angle * (1.0 - square / 6.0);
  return vec2(height, w * disc.visible * sqrt(disc.visible));
}

// Mean transmittance (3 channels) to the sun from a point, times that of the columns `before` on the way from there.
vec3 disc_light(vec3 before, float k, float y) {
  Disc disc = disc_above_horizon(k, y);
  vec3 light = vec3(0.0);
  for (int i = 0; i < STRIPS; ++i) {
    float angle;
    vec2 strip = disc_strip(disc, i, angle);
    light += strip.y * exp(-optical_depth(before + columns_to_top(k, strip.x)));
  }
  return light;
}

// Irradiance (3 channels) of a plane per irradiance on one that faces the sun: cosine of incidence of the disc's center,
// and how it grows with the angle upward.
vec3 disc_irradiance(float k, float y, float cosine, float upward) {
  Disc disc = disc_above_horizon(k, y);
  vec3 light = vec3(0.0);
  for (int i = 0; i < STRIPS; ++i) {
    float angle;
    vec2 strip = disc_strip(disc, i, angle);
    light += strip.y * max(cosine + angle * upward, 0.0) * transmittance_to_top(k, strip.x);
  }
  return light;
}
