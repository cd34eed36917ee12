#version 330 core
// Precompute a 3D table: single scattering of every texel, molecules and aerosols apart, phases left out.
//
// The planet's shadow is not in it: frames cut it out. Below the terminator the sunlight fades with the depth of its path
// under the ground, so that the table is smooth across the shadow's edge and both sides of a cut agree.

#include "segments.glsl"
#include "table_path.glsl"

const float DEEPEST = 8.0;  // scale heights under the ground, where nothing is left

layout(location = 0) out vec4 out_rayleigh;
layout(location = 1) out vec4 out_mie;

vec3 sun_columns(float k, float y) {
  vec3 columns = columns_to_top(k, y);
  float depth = y < 0.0 ? max(-altitude_of(max(k - y * y, -0.5 * u_bottom_radius * u_bottom_radius)), 0.0) : 0.0;
  columns.xy *= exp(min(depth / u_scale_height, DEEPEST));
  return columns;
}

void main() {
  TablePath path = inscatter_texel(ivec2(gl_FragCoord.xy));
  Ray ray = path.ray;
  SinhMap map = make_map(ray, 0.0, path.end);
  vec2 steps[NODE_COUNT];
  float t[NODE_COUNT];
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 node = map_node(map, NODES[i]);
    t[i] = node.x;
    steps[i] = node.y * densities(altitude_of(k_along(ray, node.x)));
  }
#ifdef HAS_OZONE
  vec3 crossings = ozone_crossings(ray.tangent_k);
  float ozone_start = ozone_to(ray.tangent_k, crossings, ray.x);
#endif
  vec3 rayleigh = vec3(0.0);
  vec3 mie = vec3(0.0);
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec3 columns = sun_columns(k_along(ray, t[i]), path.sun.x + path.sun.y * t[i]);
    for (int j = 0; j < NODE_COUNT; ++j) columns.xy += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
#ifdef HAS_OZONE
    columns.z += ozone_to(ray.tangent_k, crossings, ray.x + t[i]) - ozone_start;
#endif
    vec3 light = WEIGHTS[i] * exp(-optical_depth(columns));
    rayleigh += light * steps[i].x;
    mie += light * steps[i].y;
  }
  out_rayleigh = vec4(u_rayleigh_scattering * rayleigh, 1.0);
  out_mie = vec4(u_mie_scattering * mie, 1.0);
}
