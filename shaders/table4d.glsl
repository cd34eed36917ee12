// The published 4D table at work: inscatter of a path = S(start) - T S(end), Bruneton and Neyret 2008, eq. 13 and 16.

#include "phase.glsl"
#include "table_path.glsl"

uniform sampler2D u_inscatter;  // rgb: molecules, before the phase function; packed: higher orders in them, a: aerosols in red
#ifndef HAS_PACKED
uniform sampler2D u_inscatter_mie;
uniform sampler2D u_inscatter_multiple;  // orders from the second on, as radiance
#endif

struct Scattered {
  vec3 transmittance;
  vec3 radiance;  // 1/sr, per unit irradiance
};

struct Inscatter {
  vec3 rayleigh;
  vec3 mie;
  vec3 multiple;
};

Inscatter inscatter_from(Ray ray, vec2 sun, float t) {
  TableCell cell = inscatter_at(k_along(ray, t), ray.x + t, vec2(sun.x + sun.y * t, sun.y), ray.tangent_k, meets_ground(ray));
  vec4 stored = inscatter_fetch(u_inscatter, cell);
#ifdef HAS_PACKED
  // Aerosols light up where molecules do: their color is that of the molecules over the molecules' coefficients.
  vec3 ratio = u_mie_scattering / max(u_rayleigh_scattering, 1.0e-12);
  vec3 mie = stored.rgb * (stored.a / max(stored.r, 1.0e-9)) * ratio / max(ratio.r, 1.0e-12);
  return Inscatter(stored.rgb, mie, vec3(0.0));
#else
  return Inscatter(stored.rgb, inscatter_fetch(u_inscatter_mie, cell).rgb, inscatter_fetch(u_inscatter_multiple, cell).rgb);
#endif
}

Inscatter inscatter_piece(Inscatter near, vec3 clear, Inscatter far) {
  return Inscatter(
    max(near.rayleigh - clear * far.rayleigh, 0.0),
    max(near.mie - clear * far.mie, 0.0),
    max(near.multiple - clear * far.multiple, 0.0)
  );
}

vec3 apply_phases(Inscatter sum, float nu, float across) {
  return rayleigh_phase(nu) * sum.rayleigh + mie_phase(nu, across) * sum.mie + sum.multiple;
}

// The whole path of a ray. cuts [m]: near end, where the shadow begins and ends, far end.
Scattered scatter(Ray ray, vec2 sun, float across, vec4 cuts) {
  vec3 near = columns_beyond(ray, cuts.x);
  vec3 clear = clearness(near, columns_beyond(ray, cuts.w));
  Inscatter whole = inscatter_piece(inscatter_from(ray, sun, cuts.x), clear, inscatter_from(ray, sun, cuts.w));
#ifdef HAS_PIECES
  // the lit pieces are what is left of the path without its dark part
  vec3 to_dark = clearness(near, columns_beyond(ray, cuts.y));
  vec3 to_light = clearness(near, columns_beyond(ray, cuts.z));
  Inscatter dark = inscatter_piece(inscatter_from(ray, sun, cuts.y), to_light / max(to_dark, 1.0e-12), inscatter_from(ray, sun, cuts.z));
  whole.rayleigh = max(whole.rayleigh - to_dark * dark.rayleigh, 0.0);
  whole.mie = max(whole.mie - to_dark * dark.mie, 0.0);
#endif
  return Scattered(clear, apply_phases(whole, sun.y, across));
}
