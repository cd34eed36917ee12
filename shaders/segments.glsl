// Single scattering over the lit pieces of a ray: Gauss-Legendre quadrature in a sinh map about the tangent point.
//
// The integrand over one lit piece is analytic, so that few nodes converge once the shadow edge is an end point and not
// inside. The map spreads the nodes by the width of the densest layer's bump about the point of the piece nearest to the
// ground, and optical depth pulls its center towards the camera. The view's own columns at the nodes come from the same
// densities by the integrals of the Lagrange basis (no fetch). Phases and scattering coefficients are applied last.

#ifdef HAS_ECLIPSE
#include "eclipse.glsl"

const float LEAST_LIGHT = 1.0e-3;  // m; what an unlit node counts, so that every path has a mean visibility
#endif
#ifdef HAS_TERMINATOR
#include "terminator.glsl"
#endif
#ifdef HAS_TERMINATOR_MOONS
#include "terminator_moons.glsl"
#endif
#include "phase.glsl"
#include "transmittance.glsl"

uniform vec2 u_dominant;  // scale height [m] and vertical-path extinction [1/m] of the layer that shapes the piece

const float NODES[NODE_COUNT] = NODE_VALUES;
const float WEIGHTS[NODE_COUNT] = WEIGHT_VALUES;
const float CUMULATIVE[NODE_COUNT * NODE_COUNT] = CUMULATIVE_VALUES;
const float GAP_NODES[GAP_COUNT] = GAP_NODE_VALUES;
const float GAP_WEIGHTS[GAP_COUNT] = GAP_WEIGHT_VALUES;

struct SinhMap {
  float center;  // t of the center, m
  float width;   // m
  float start;   // u of the piece's near end
  float span;    // difference of u over the piece
};

float arsinh(float z) {
  float size = min(abs(z), 1.0e18);  // its square is a float
  float magnitude = log(size + sqrt(size * size + 1.0));
  return z < 0.0 ? -magnitude : magnitude;
}

#ifdef HAS_THICK_AIR
// An optical depth that grows along the ray, up to a constant: twice the tangent's less the rest. A bound of the closed
// form, 1 percent off.
vec2 outward_columns(float x, float altitude) {
  vec2 scale = sqrt(2.0 * u_scale_height * (u_bottom_radius + altitude));
  vec2 z = x / scale;
  return scale * densities(altitude) / (z + sqrt(z * z + 4.0 / PI));
}
vec3 slant_depth(Ray ray, float t) {
  float x = ray.x + t;
  vec2 columns = outward_columns(abs(x), altitude_of(k_along(ray, t)));
  if (x >= 0.0) columns = 2.0 * outward_columns(0.0, altitude_of(max(ray.tangent_k, 0.0))) - columns;
  return optical_depth(vec3(columns, 0.0));
}

float largest(vec3 v) { return max(max(v.x, v.y), v.z); }
float smallest(vec3 v) { return min(min(v.x, v.y), v.z); }
float largest_extinction(Ray ray, float t) {
  return largest(optical_depth(vec3(densities(altitude_of(k_along(ray, t))), 0.0)));
}

// Center, width and far end of a map go where something can be seen: the center to an optical depth of 1 in the thickest
// channel, the far end to 16 in the thinnest. Where the air is dense from the near end on, the
// center goes there; beneath a dense top the light may even come from a hair of the piece. Pieces of an optical depth
// below 10 need no such care.
void see_no_farther(Ray ray, float near, inout float far, inout SinhMap map) {
  vec3 before = slant_depth(ray, near);
  if (largest(slant_depth(ray, far) - before) <= 10.0) return;
  vec2 low = vec2(near);
  vec2 high = vec2(far);
  for (int i = 0; i < 24; ++i) {
    vec2 middle = 0.5 * (low + high);
    bvec2 beyond = bvec2(largest(slant_depth(ray, middle.x) - before) > 1.0, smallest(slant_depth(ray, middle.y) - before) > 16.0);
    low = mix(middle, low, vec2(beyond));
    high = mix(high, middle, vec2(beyond));
  }
  float here = largest_extinction(ray, near);
  float there = largest_extinction(ray, high.x);
  bool immersed = here > 0.2 * there;
  map.center = immersed ? near : high.x;
  bool below_top = k_along(ray, near) > 0.999 * u_top_k;
  map.width = (immersed ? (below_top ? 0.05 : 1.0) : 3.0) / max(immersed ? here : there, 1.0e-30);
  far = high.y;
}
#endif

SinhMap make_map(Ray ray, float near, float far) {
#ifdef HAS_DEEP_SHELL
  // Only where the layers count do nodes pay.
  float half_chord = safe_sqrt(u_reach_k - ray.tangent_k);
  near = clamp(-ray.x - half_chord, near, far);
  far = clamp(-ray.x + half_chord, near, far);
#endif
  float scale = u_dominant.x;
  float lowest = clamp(-ray.x, near, far);
  float altitude = altitude_of(k_along(ray, lowest));
  float r = u_bottom_radius + altitude;
  float bump = sqrt(r * scale);
  float depth = u_dominant.y * bump * exp(-max(altitude, 0.0) / scale);
  SinhMap map;
  map.center = clamp(-ray.x - 0.45 * bump * log(1.0 + depth), near, far);
  float slope = (ray.x + lowest) / r;
#ifdef HAS_SMALL_PLANET
  float width = scale * inversesqrt(slope * slope + 0.5 * scale / r * (1.0 + scale / r));
#else
  float width = scale * inversesqrt(slope * slope + 0.5 * scale / r);
#endif
  map.width = length(vec2(0.9 * width, 0.5 * (map.center - lowest)));
#ifdef HAS_THICK_AIR
  see_no_farther(ray, near, far, map);
#endif
  float a = (near - map.center) / map.width;
  float b = (far - map.center) / map.width;
  map.start = arsinh(a);
  // The difference of two nearly equal logarithms loses its digits on a short piece; its derivative does not.
  float middle = 0.5 * (a + b);
  map.span = b - a < 0.02 ? (b - a) * inversesqrt(1.0 + middle * middle) : arsinh(b) - map.start;
  return map;
}

// t and dt/ds of a node at s in 0..1.
vec2 map_node(SinhMap map, float s) {
#ifdef HAS_DENSE_TOP
  // Beneath a dense top the sun's column grows with the square root of the depth: a cubic in s follows it at either end.
  float stretch = 6.0 * s * (1.0 - s);
  s *= s * (3.0 - 2.0 * s);
  float e = exp(map.start + map.span * s);
  float inverse = 1.0 / e;
  return 0.5 * map.width * vec2(e - inverse, map.span * stretch * (e + inverse)) + vec2(map.center, 0.0);
#else
  float e = exp(map.start + map.span * s);
  float inverse = 1.0 / e;
  return vec2(map.center + 0.5 * map.width * (e - inverse), 0.5 * map.width * map.span * (e + inverse));
#endif
}

struct Inscatter {
  vec3 rayleigh;  // m, integral of density x transmittance to the eye x transmittance to the sun
  vec3 mie;
  vec3 columns;  // m, of the air between the base point and where the next piece begins
#ifdef HAS_ECLIPSE
  vec2 light;  // m, of green light that the moons leave, and of all
#endif
};

Inscatter no_inscatter() {
  Inscatter sum;
  sum.rayleigh = vec3(0.0);
  sum.mie = vec3(0.0);
  sum.columns = vec3(0.0);
#ifdef HAS_ECLIPSE
  sum.light = vec2(0.0);
#endif
  return sum;
}

// Columns of a piece that sends no light of its own.
void pass_gap(Ray ray, float near, float far, inout Inscatter sum) {
  SinhMap map = make_map(ray, near, far);
  for (int i = 0; i < GAP_COUNT; ++i) {
    vec2 node = map_node(map, GAP_NODES[i]);
    sum.columns.xy += GAP_WEIGHTS[i] * node.y * densities(altitude_of(k_along(ray, node.x)));
  }
}

// Inscatter and columns of a lit piece. `sun` = height of the base point above the terminator plane [m] and its
// derivative along the ray, the cosine nu.
void add_piece(Ray ray, vec2 sun, float near, float far, inout Inscatter sum) {
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
  for (int i = 0; i < NODE_COUNT; ++i) {
#ifdef HAS_TERMINATOR
    vec3 columns = vec3(sum.columns.xy, 0.0);
#else
    vec3 columns = columns_to_top(k_along(ray, t[i]), sun.x + sun.y * t[i]);
    columns.xy += sum.columns.xy;
#endif
    for (int j = 0; j < NODE_COUNT; ++j) columns.xy += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
#ifdef HAS_OZONE
    columns.z += ozone_to(ray.tangent_k, crossings, ray.x + t[i]) - ozone_start;
#endif
#ifdef HAS_TERMINATOR
    vec3 light = WEIGHTS[i] * disc_light(columns, k_along(ray, t[i]), sun.x + sun.y * t[i]);
#else
    vec3 light = WEIGHTS[i] * exp(-optical_depth(columns));
#endif
#ifdef HAS_ECLIPSE
#ifdef HAS_TERMINATOR_MOONS
    vec3 visible = disc_visibility_along(t[i], k_along(ray, t[i]), sun.x + sun.y * t[i]);
    sum.light += vec2(visible.y, 1.0) * (light.y * (steps[i].x + steps[i].y) + LEAST_LIGHT);
#else
    float visible = visibility_along(t[i]);
    sum.light += vec2(visible, 1.0) * (light.y * (steps[i].x + steps[i].y) + LEAST_LIGHT);
#endif
    light *= visible;
#endif
    sum.rayleigh += light * steps[i].x;
    sum.mie += light * steps[i].y;
  }
  for (int i = 0; i < NODE_COUNT; ++i) sum.columns.xy += WEIGHTS[i] * steps[i];
}

void add_lit(Ray ray, vec2 sun, float near, float far, inout Inscatter sum) {
#ifdef HAS_OPAQUE_OZONE
  // A low sun lights the air above the layer alone: a kink at its upper end, where the piece leaves it, or else enters.
  float half_chord = safe_sqrt(u_ozone_k.z - ray.tangent_k);
  float middle = half_chord - ray.x;
  if (middle <= near || middle >= far) middle = clamp(-half_chord - ray.x, near, far);
  add_piece(ray, sun, near, middle, sum);
  near = middle;
#endif
  add_piece(ray, sun, near, far, sum);
}

// The ozone of the whole path in one go: its column has a closed form, so the pieces need not carry it.
void finish_columns(Ray ray, float end, inout Inscatter sum) {
#ifdef HAS_OZONE
  vec3 crossings = ozone_crossings(ray.tangent_k);
  float column = ozone_to(ray.tangent_k, crossings, ray.x + end) - ozone_to(ray.tangent_k, crossings, ray.x);
  sum.columns.z = max(column, 0.0);  // beside the layer a difference of two equal numbers, but for their last digits
#endif
}

// Radiance per unit irradiance [1/sr] of the inscatter integrals; across = 1 - nu^2.
vec3 apply_phases(Inscatter sum, float nu, float across) {
  return rayleigh_phase(nu) * u_rayleigh_scattering * sum.rayleigh + mie_phase(nu, across) * u_mie_scattering * sum.mie;
}

struct Scattered {
  vec3 transmittance;
  vec3 radiance;  // 1/sr, per unit irradiance
#ifdef HAS_ECLIPSE
  float visibility;  // of the sun from where the light comes from
#endif
};

#ifdef HAS_ECLIPSE
float mean_visibility(vec2 light) { return light.y > 0.0 ? light.x / light.y : 1.0; }
#endif

// The whole path of a ray. cuts [m]: near end, where the shadow begins and ends, far end.
Scattered scatter(Ray ray, vec2 sun, float across, vec4 cuts) {
  Inscatter sum = no_inscatter();
#ifdef HAS_SHADOW
#ifdef HAS_TWO_PIECES
#ifdef HAS_LONG_PATHS
  // Without a shadow on it the path is cut where most of its light comes from, so that both pieces' nodes count.
  bool whole = cuts.z <= cuts.y;
#ifdef HAS_TERMINATOR
  whole = whole && (cuts.y <= cuts.x || cuts.y >= cuts.w);  // else the dusk of a disc cuts it
#endif
  float middle = whole ? make_map(ray, cuts.x, cuts.w).center : 0.0;
  cuts.yz = whole ? vec2(middle) : cuts.yz;
#endif
  add_lit(ray, sun, cuts.x, cuts.y, sum);
  pass_gap(ray, cuts.y, cuts.z, sum);
  add_lit(ray, sun, cuts.z, cuts.w, sum);
#else
  // One lit piece on either side of the shadow, so its place decides what stands before it.
  bool shadow_first = cuts.y <= cuts.x;
  Inscatter gap = no_inscatter();
  pass_gap(ray, cuts.y, cuts.z, gap);
  sum.columns = shadow_first ? gap.columns : vec3(0.0);
  add_lit(ray, sun, shadow_first ? cuts.z : cuts.x, shadow_first ? cuts.w : cuts.y, sum);
  sum.columns += shadow_first ? vec3(0.0) : gap.columns;
#endif
#else
  add_lit(ray, sun, cuts.x, cuts.w, sum);
#endif
  finish_columns(ray, cuts.w, sum);
  Scattered air;
  air.transmittance = exp(-optical_depth(sum.columns));
  air.radiance = apply_phases(sum, sun.y, across);
#ifdef HAS_ECLIPSE
  air.visibility = mean_visibility(sum.light);
#endif
  return air;
}
