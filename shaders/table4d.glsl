// The published 4D table at work: inscatter of a path = S(start) - T S(end), Bruneton and Neyret 2008, eq. 13 and 16.

#include "phase.glsl"
#include "table_path.glsl"

// Molecules, before the phase function. HAS_PACKED: a = aerosols in red. HAS_COMBINED: higher orders are in them too.
uniform sampler2D u_inscatter;
#ifndef HAS_PACKED
uniform sampler2D u_inscatter_mie;
#endif
#ifndef HAS_COMBINED
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

TableCell cell_at(Ray ray, vec2 sun, float t) {
  return inscatter_at(k_along(ray, t), ray.x + t, vec2(sun.x + sun.y * t, sun.y), ray.tangent_k, meets_ground(ray));
}

#ifdef HAS_PACKED
// Aerosols light up where molecules do: their color is that of the molecules over the molecules' coefficients.
Inscatter unpacked(vec4 stored, vec3 multiple) {
  vec3 ratio = u_mie_scattering / max(u_rayleigh_scattering, 1.0e-12);
  vec3 mie = stored.rgb * (stored.a / max(stored.r, 1.0e-9)) * ratio / max(ratio.r, 1.0e-12);
  return Inscatter(stored.rgb, mie, multiple);
}
#endif

Inscatter inscatter_from(Ray ray, vec2 sun, float t) {
  TableCell cell = cell_at(ray, sun, t);
  vec4 stored = inscatter_fetch(u_inscatter, cell);
  vec3 multiple = vec3(0.0);
#ifndef HAS_COMBINED
  multiple = inscatter_fetch(u_inscatter_multiple, cell).rgb;
#endif
#ifdef HAS_PACKED
  return unpacked(stored, multiple);
#else
  return Inscatter(stored.rgb, inscatter_fetch(u_inscatter_mie, cell).rgb, multiple);
#endif
}

#ifdef HAS_TABLE4D_VIEW
uniform sampler2D u_view_inscatter;
uniform sampler2D u_view_inscatter_multiple;

// The same from the camera, by the table that table4d_view.frag made for it.
Inscatter inscatter_from_camera(Ray ray, vec2 sun) {
  vec2 place = inscatter_place(ray.k, ray.x, sun, ray.tangent_k, meets_ground(ray)).wy;
  vec2 texel = view_texel(place, meets_ground(ray));
  return unpacked(texture(u_view_inscatter, texel), texture(u_view_inscatter_multiple, texel).rgb);
}
#endif

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
#ifdef HAS_OPEN_END
  // Beyond the top there is nothing to take away.
  vec3 clear = exp(-optical_depth(near));
#else
  vec3 clear = clearness(near, columns_beyond(ray, cuts.w));
#endif
#ifdef HAS_TABLE4D_VIEW
  Inscatter sum = inscatter_from_camera(ray, sun);
#else
  Inscatter sum = inscatter_from(ray, sun, cuts.x);
#endif
#ifndef HAS_OPEN_END
  sum = inscatter_piece(sum, clear, inscatter_from(ray, sun, cuts.w));
#endif
#ifdef HAS_SHADOW
#ifndef HAS_COMBINED
  // The lit pieces are the path without its dark part, where the table's cells mix light across the shadow's edge. Light
  // scattered more than once is in the dark part too, and stays where a texture of its own holds it.
  vec3 to_dark = columns_beyond(ray, cuts.y);
  vec3 to_light = columns_beyond(ray, cuts.z);
  Inscatter dark = inscatter_piece(inscatter_from(ray, sun, cuts.y), clearness(to_dark, to_light), inscatter_from(ray, sun, cuts.z));
  vec3 before = clearness(near, to_dark);
  sum.rayleigh = max(sum.rayleigh - before * dark.rayleigh, 0.0);
  sum.mie = max(sum.mie - before * dark.mie, 0.0);
#endif
#endif
  return Scattered(clear, apply_phases(sum, sun.y, across));
}
