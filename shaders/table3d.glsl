// The 3D tables at work: inscatter of a lit piece = S(start) - T S(end), Schafhitzel, Falk, Ertl 2007, eq. 8.
//
// The cuts of the depth textures give these tables the planet's shadow, which without azimuth they cannot hold.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_inscatter;      // molecules, before the phase function
uniform sampler2D u_inscatter_mie;  // aerosols

struct Scattered {
  vec3 transmittance;
  vec3 radiance;  // 1/sr, per unit irradiance
};

struct Inscatter {
  vec3 rayleigh;
  vec3 mie;
};

Inscatter inscatter_from(Ray ray, vec2 sun, float t) {
  vec2 sun_there = vec2(sun.x + sun.y * t, sun.y);
  TableCell cell = inscatter_at(k_along(ray, t), ray.x + t, sun_there, ray.tangent_k, meets_ground(ray));
  return Inscatter(inscatter_fetch(u_inscatter, cell).rgb, inscatter_fetch(u_inscatter_mie, cell).rgb);
}

// Adds a lit piece; start = columns beyond the base point.
void add_piece(Ray ray, vec2 sun, vec3 start, float from, float to, inout Inscatter sum) {
  vec3 near = columns_beyond(ray, from);
  vec3 clear = clearness(near, columns_beyond(ray, to));
  vec3 before = clearness(start, near);
  Inscatter a = inscatter_from(ray, sun, from);
  Inscatter b = inscatter_from(ray, sun, to);
  // without azimuth the two ends may disagree; less than nothing is nothing
  sum.rayleigh += before * max(a.rayleigh - clear * b.rayleigh, 0.0);
  sum.mie += before * max(a.mie - clear * b.mie, 0.0);
}

// The whole path of a ray. cuts [m]: near end, where the shadow begins and ends, far end.
Scattered scatter(Ray ray, vec2 sun, float across, vec4 cuts) {
  Inscatter sum = Inscatter(vec3(0.0), vec3(0.0));
  vec3 start = columns_beyond(ray, 0.0);
#ifdef HAS_SHADOW
#ifdef HAS_TWO_PIECES
  add_piece(ray, sun, start, cuts.x, cuts.y, sum);
  add_piece(ray, sun, start, cuts.z, cuts.w, sum);
#else
  bool shadow_first = cuts.y <= cuts.x;
  add_piece(ray, sun, start, shadow_first ? cuts.z : cuts.x, shadow_first ? cuts.w : cuts.y, sum);
#endif
#else
  add_piece(ray, sun, start, cuts.x, cuts.w, sum);
#endif
#ifdef HAS_AD_HOC_PHASE
  float molecules = ad_hoc_phase(sun.y);
#else
  float molecules = rayleigh_phase(sun.y);
#endif
  vec3 radiance = molecules * sum.rayleigh + mie_phase(sun.y, across) * sum.mie;
  return Scattered(clearness(start, columns_beyond(ray, cuts.w)), radiance);
}
