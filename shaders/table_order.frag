#version 330 core
// Precompute, step 4: one more order of scattering along the path of every texel, lit and shadowed alike.

#include "segments.glsl"
#include "table_path.glsl"

#ifdef HAS_SPECIES
uniform sampler2D u_gathered_rayleigh;
uniform sampler2D u_gathered_mie;
layout(location = 0) out vec4 out_rayleigh;
layout(location = 1) out vec4 out_mie;
#else
uniform sampler2D u_gathered;
out vec4 out_radiance;
#endif

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
    vec3 columns = vec3(0.0);
    for (int j = 0; j < NODE_COUNT; ++j) columns.xy += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
#ifdef HAS_OZONE
    columns.z = ozone_to(ray.tangent_k, crossings, ray.x + t[i]) - ozone_start;
#endif
    vec3 clear = WEIGHTS[i] * exp(-optical_depth(columns));
    vec2 sun = vec2(path.sun.x + path.sun.y * t[i], path.sun.y);
    TableCell cell = inscatter_at(k_along(ray, t[i]), ray.x + t[i], sun, ray.tangent_k, path.ground);
#ifdef HAS_SPECIES
    rayleigh += steps[i].x * clear * inscatter_fetch(u_gathered_rayleigh, cell).rgb;
    mie += steps[i].y * clear * inscatter_fetch(u_gathered_mie, cell).rgb;
#else
    vec3 gathered = clear * inscatter_fetch(u_gathered, cell).rgb;
    rayleigh += steps[i].x * gathered;
    mie += steps[i].y * gathered;
#endif
  }
  rayleigh *= u_rayleigh_scattering;
  mie *= u_mie_scattering;
#ifdef HAS_SPECIES
  out_rayleigh = vec4(rayleigh, 1.0);
  out_mie = vec4(mie, 1.0);
#else
  out_radiance = vec4(rayleigh + mie, 1.0);
#endif
}
