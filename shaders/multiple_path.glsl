// Multiple scattering along a ray: the table's source at Gauss-Legendre nodes of lit and shadowed pieces alike.

#include "multiple.glsl"
#include "segments.glsl"

#ifdef HAS_MULTIPLE
const float GAP_CUMULATIVE[GAP_COUNT * GAP_COUNT] = GAP_CUMULATIVE_VALUES;

struct Gathered {
  vec3 radiance;  // 1/sr
  vec2 columns;   // m, of the exponential layers up to where the next piece begins
};

// Transmittance from the base point to t, given the exponential layers' columns.
vec3 clearness(Ray ray, vec2 columns, float t) {
  vec3 all = vec3(columns, 0.0);
#ifdef HAS_OZONE
  vec3 crossings = ozone_crossings(ray.tangent_k);
  all.z = ozone_to(ray.tangent_k, crossings, ray.x + t) - ozone_to(ray.tangent_k, crossings, ray.x);
#endif
  return exp(-optical_depth(all));
}

// What keeps few nodes from scattering more light than a piece takes out of a ray: in air so thick that the nodes step over
// many mean free paths, the orders of scattering would grow without bound.
vec3 gain(vec3 taken, vec3 lost) { return min(vec3(1.0), max(taken, 0.0) / max(lost, 1.0e-30)); }

// Source [1/sr] times dt/ds at a node; step = densities times dt/ds.
vec3 node_source(Ray ray, vec2 sun, float t, vec2 step) {
  float altitude = altitude_of(k_along(ray, t));
  float r = u_bottom_radius + altitude;
  vec2 cosines = vec2(sun.x + sun.y * t, ray.x + t) / r;
  return multiple_source(step.x * u_rayleigh_scattering, step.y * u_mie_scattering, altitude, cosines.x, cosines.y, sun.y);
}

void gather_lit(Ray ray, vec2 sun, float near, float far, vec3 kernel, inout Gathered sum) {
  SinhMap map = make_map(ray, near, far);
  vec2 steps[NODE_COUNT];
  float t[NODE_COUNT];
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 node = map_node(map, NODES[i]);
    t[i] = node.x;
    steps[i] = node.y * densities(altitude_of(k_along(ray, node.x)));
  }
  vec3 radiance = vec3(0.0);
  vec3 lost = vec3(0.0);
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 columns = sum.columns;
    for (int j = 0; j < NODE_COUNT; ++j) columns += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
    vec3 clear = WEIGHTS[i] * clearness(ray, columns, t[i]);
    lost += clear * optical_depth(vec3(steps[i], 0.0));
    vec3 source = node_source(ray, sun, t[i], steps[i]);
#ifdef HAS_AUREOLE
    float k = k_along(ray, t[i]);
    float y = sun.x + sun.y * t[i];
    vec3 sun_columns = columns_to_top(k, y);
    vec3 light = exp(-optical_depth(sun_columns));
    source += aureole_source(steps[i].y, y / (u_bottom_radius + altitude_of(k)), light, sun_columns.y, kernel);
#endif
    radiance += clear * source;
  }
  vec3 before = clearness(ray, sum.columns, near);
  for (int i = 0; i < NODE_COUNT; ++i) sum.columns += WEIGHTS[i] * steps[i];
  sum.radiance += radiance * gain(before - clearness(ray, sum.columns, far), lost);
}

void gather_gap(Ray ray, vec2 sun, float near, float far, inout Gathered sum) {
  SinhMap map = make_map(ray, near, far);
  vec2 steps[GAP_COUNT];
  float t[GAP_COUNT];
  for (int i = 0; i < GAP_COUNT; ++i) {
    vec2 node = map_node(map, GAP_NODES[i]);
    t[i] = node.x;
    steps[i] = node.y * densities(altitude_of(k_along(ray, node.x)));
  }
  vec3 radiance = vec3(0.0);
  vec3 lost = vec3(0.0);
  for (int i = 0; i < GAP_COUNT; ++i) {
    vec2 columns = sum.columns;
    for (int j = 0; j < GAP_COUNT; ++j) columns += GAP_CUMULATIVE[i * GAP_COUNT + j] * steps[j];
    vec3 clear = GAP_WEIGHTS[i] * clearness(ray, columns, t[i]);
    lost += clear * optical_depth(vec3(steps[i], 0.0));
    radiance += clear * node_source(ray, sun, t[i], steps[i]);
  }
  vec3 before = clearness(ray, sum.columns, near);
  for (int i = 0; i < GAP_COUNT; ++i) sum.columns += GAP_WEIGHTS[i] * steps[i];
  sum.radiance += radiance * gain(before - clearness(ray, sum.columns, far), lost);
}

// The whole path; cuts [m] as in segments.glsl. Branches: for tables and single rays, where most paths have one piece.
Gathered gather(Ray ray, vec2 sun, vec4 cuts, vec3 kernel) {
  Gathered sum = Gathered(vec3(0.0), vec2(0.0));
  if (cuts.y > cuts.x) gather_lit(ray, sun, cuts.x, cuts.y, kernel, sum);
  if (cuts.z > cuts.y) gather_gap(ray, sun, cuts.y, cuts.z, sum);
  if (cuts.w > cuts.z) gather_lit(ray, sun, cuts.z, cuts.w, kernel, sum);
  sum.radiance = max(sum.radiance, 0.0);
  return sum;
}
#endif
