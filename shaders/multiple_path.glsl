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

// Source [1/sr] times dt/ds at a node; step = densities times dt/ds.
vec3 node_source(Ray ray, vec2 sun, float t, vec2 step) {
  float altitude = altitude_of(k_along(ray, t));
  float r = u_bottom_radius + altitude;
  vec3 scattering = step.x * u_rayleigh_scattering + step.y * u_mie_scattering;
  return scattering * multiple_radiance(altitude, (sun.x + sun.y * t) / r, (ray.x + t) / r, sun.y);
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
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 columns = sum.columns;
    for (int j = 0; j < NODE_COUNT; ++j) columns += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
    vec3 source = node_source(ray, sun, t[i], steps[i]);
#ifdef HAS_AUREOLE
    float k = k_along(ray, t[i]);
    float y = sun.x + sun.y * t[i];
    vec3 sun_columns = columns_to_top(k, y);
    vec3 light = exp(-optical_depth(sun_columns));
    source += aureole_source(steps[i].y, y / (u_bottom_radius + altitude_of(k)), light, sun_columns.y, kernel);
#endif
    sum.radiance += WEIGHTS[i] * source * clearness(ray, columns, t[i]);
  }
  for (int i = 0; i < NODE_COUNT; ++i) sum.columns += WEIGHTS[i] * steps[i];
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
  for (int i = 0; i < GAP_COUNT; ++i) {
    vec2 columns = sum.columns;
    for (int j = 0; j < GAP_COUNT; ++j) columns += GAP_CUMULATIVE[i * GAP_COUNT + j] * steps[j];
    sum.radiance += GAP_WEIGHTS[i] * node_source(ray, sun, t[i], steps[i]) * clearness(ray, columns, t[i]);
  }
  for (int i = 0; i < GAP_COUNT; ++i) sum.columns += GAP_WEIGHTS[i] * steps[i];
}

// The whole path; cuts [m] as in segments.glsl. Branches: for tables and single rays, where most paths have one piece.
Gathered gather(Ray ray, vec2 sun, vec4 cuts, vec3 kernel) {
  Gathered sum = Gathered(vec3(0.0), vec2(0.0));
  if (cuts.y > cuts.x) gather_lit(ray, sun, cuts.x, cuts.y, kernel, sum);
  if (cuts.z > cuts.y) gather_gap(ray, sun, cuts.y, cuts.z, sum);
  if (cuts.w > cuts.z) gather_lit(ray, sun, cuts.z, cuts.w, kernel, sum);
  return sum;
}
#endif
