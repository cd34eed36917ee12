#version 330 core
// Solve: radiance without a moon and with it in the gathered directions (across) at the nodes of its volume (up).

#ifdef HAS_MULTIPLE
#include "eclipse_multiple_path.glsl"
#else
#include "eclipse.glsl"
#include "multiple.glsl"
#include "segments.glsl"
#endif
#include "shadow.glsl"

uniform Cone u_shadow;           // the planet's, for the parallel sun
uniform sampler2D u_columns;     // unit vectors of the volume's columns
uniform sampler2D u_directions;  // mu of the gathered directions, by altitude
uniform mat3 u_frame;            // from planet-centered coordinates to the shadow's frame
uniform vec3 u_sun_direction;
uniform vec3 u_ground_albedo;
uniform int u_moon;
#ifndef HAS_MULTIPLE
uniform float u_band[BAND_COUNT];  // Legendre series of the aerosols' phase function

float band_phase(float nu) {
  float before = 1.0;
  float current = nu;
  float sum = u_band[0];
  for (int l = 1; l < BAND_COUNT; ++l) {
    sum += u_band[l] * current;
    float after = (float(2 * l + 1) * nu * current - float(l) * before) / float(l + 1);
    before = current;
    current = after;
  }
  return sum;
}

// Single scattering of a lit piece, without the moon and with it; columns as in multiple_path.glsl.
void first_order(Ray ray, vec2 sun, float near, float far, bool lit, vec2 phases, inout vec3 columns, inout vec3 without,
                 inout vec3 with) {
  SinhMap map = make_map(ray, near, far);
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
  for (int i = 0; lit && i < NODE_COUNT; ++i) {
    vec3 all = columns_to_top(k_along(ray, t[i]), sun.x + sun.y * t[i]);
    all.xy += columns.xy;
    for (int j = 0; j < NODE_COUNT; ++j) all.xy += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
#ifdef HAS_OZONE
    all.z += ozone_to(ray.tangent_k, crossings, ray.x + t[i]) - ozone_start;
#endif
    vec3 source = u_rayleigh_scattering * (steps[i].x * phases.x) + u_mie_scattering * (steps[i].y * phases.y);
    vec3 light = WEIGHTS[i] * exp(-optical_depth(all)) * source;
    without += light;
    with += light * visible_fraction(eclipse_base + t[i] * eclipse_direction, u_moon);
  }
  for (int i = 0; i < NODE_COUNT; ++i) columns.xy += WEIGHTS[i] * steps[i];
}
#endif

layout(location = 0) out vec4 out_without;
layout(location = 1) out vec4 out_with;

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  int height = texel.y / COLUMNS;
  float altitude = height_of(float(height) / float(RATIO_HEIGHTS - 1));
  vec3 up = texelFetch(u_columns, ivec2(texel.y % COLUMNS, 0), 0).xyz;
  float mu = texelFetch(u_directions, ivec2(texel.x / AROUND, height), 0).x;
  float azimuth = 2.0 * PI * (float(texel.x % AROUND) + 0.5) / float(AROUND);
  float sine = safe_sqrt(1.0 - mu * mu);
  vec3 turned = vec3(sine * cos(azimuth), sine * sin(azimuth), mu);
  vec3 u = u_frame * up;
  vec3 s = u + vec3(0.0, 0.0, 1.0);
  vec3 direction = (turned - dot(turned, s) / max(s.z, 1.0e-4) * s + 2.0 * turned.z * u) * u_frame;
  float mu_s = dot(up, u_sun_direction);
  float nu = clamp(dot(direction, u_sun_direction), -1.0, 1.0);

  float r = u_bottom_radius + altitude;
  float k = min(altitude * (2.0 * u_bottom_radius + altitude), u_top_k);
  Ray ray = make_ray(r * mu, k, k - r * mu * r * mu);
  float z = -r * mu_s;
  float across = max(1.0 - nu * nu, 0.0);
  float drift = r * mu + z * nu;
  float impact = safe_sqrt(across * (r * r - z * z) - drift * drift);
  vec2 shadow = cone_interval(AxisRay(z, -nu, across, drift, impact, k - z * z), u_shadow, 1.0);
  float ground = ground_distance(ray);
  float end = ground >= 0.0 ? ground : max(ray.air, 0.0);
  float from = clamp(shadow.x, 0.0, end);
  vec4 cuts = vec4(0.0, from, clamp(shadow.y, from, end), end);
  vec2 sun = vec2(-z, nu);
  float ground_sun = (sun.x + sun.y * end) / u_bottom_radius;
  eclipse_base = up * r;
  eclipse_direction = direction;
  vec3 landing = eclipse_base + end * direction;

#ifdef HAS_MULTIPLE
  Shaded sum = gather_shaded(ray, sun, cuts, vec3(0.0), u_moon);
  vec3 without = sum.without;
  vec3 with = sum.with;
  vec3 transmittance = clearness(ray, sum.columns, end);
  vec3 irradiance = ground_irradiance(ground_sun);
  vec3 shaded = irradiance * ground_ratio_under(landing / u_bottom_radius, u_moon, visible_fraction(landing, u_moon));
#else
  vec3 without = vec3(0.0);
  vec3 with = vec3(0.0);
  vec3 columns = vec3(0.0);
  vec2 phases = vec2(rayleigh_phase(nu), band_phase(nu));
  for (int i = 0; i < 3; ++i) {
    if (cuts[i + 1] > cuts[i]) first_order(ray, sun, cuts[i], cuts[i + 1], i != 1, phases, columns, without, with);
  }
#ifdef HAS_OZONE
  vec3 crossings = ozone_crossings(ray.tangent_k);
  columns.z = ozone_to(ray.tangent_k, crossings, ray.x + end) - ozone_to(ray.tangent_k, crossings, ray.x);
#endif
  vec3 transmittance = exp(-optical_depth(columns));
  float height_of_sun = max(ground_sun, 0.0);
  vec3 irradiance = height_of_sun * transmittance_to_top(0.0, height_of_sun * u_bottom_radius);
  vec3 shaded = irradiance * visible_fraction(landing, u_moon);
#endif
  vec3 reflected = ground >= 0.0 ? transmittance * u_ground_albedo / PI : vec3(0.0);
  out_without = vec4(without + reflected * irradiance, 1.0);
  out_with = vec4(with + reflected * shaded, 1.0);
}
