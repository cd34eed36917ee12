// What moons and rings leave of the light of a table that knows none of them.
//
// A table's inscatter is of whole lit pieces. All that can be done for it is the mean of the visible fraction along them,
// weighted by the green light that single scattering sends from there, at uniform steps. Light scattered more than once
// fades with it, so that totality is black.

#include "eclipse.glsl"
#include "table_path.glsl"

const int ECLIPSE_STEPS = 24;
const float LEAST_LIGHT = 1.0e-3;  // m; what an unlit step counts, so that every path has a mean

float path_visibility(Ray ray, vec2 sun, vec4 cuts) {
  float length = (cuts.w - cuts.x) / float(ECLIPSE_STEPS);
  vec3 near = columns_beyond(ray, cuts.x);
  vec2 seen = vec2(0.0);
  for (int i = 0; i < ECLIPSE_STEPS; ++i) {
    float t = cuts.x + (float(i) + 0.5) * length;
    float k = k_along(ray, t);
    vec2 amount = densities(altitude_of(k)) * length;
    vec3 light = clearness(near, columns_beyond(ray, t)) * exp(-optical_depth(columns_to_top(k, sun.x + sun.y * t)));
    bool lit = t <= cuts.y || t >= cuts.z;
    float weight = LEAST_LIGHT + (lit ? light.y * (amount.x + amount.y) : 0.0);
    seen += weight * vec2(visibility_along(t), 1.0);
  }
  return seen.x / seen.y;
}
