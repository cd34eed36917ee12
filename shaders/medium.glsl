// What the air is made of: two exponential layers and an absorbing tent layer.

uniform vec2 u_scale_height;         // m: molecules, aerosols
uniform vec2 u_falloff;              // 1/m, 1 / u_scale_height
uniform vec3 u_rayleigh_scattering;  // 1/m at altitude 0
uniform vec3 u_mie_scattering;       // 1/m at altitude 0
uniform vec3 u_mie_extinction;       // 1/m at altitude 0

#ifdef COLUMN_COUNT
uniform vec2 u_column_rule[COLUMN_COUNT];  // of the quadrature of columns: nodes and weights on 0..1
uniform int u_column_count;                // COLUMN_COUNT, unknown to the compiler: unrolled loops took it a minute
#endif

#ifdef HAS_DEEP_SHELL
uniform float u_reach_k;  // m^2: k above which the layers no longer count
#endif

#ifdef HAS_OZONE
uniform vec3 u_ozone_extinction;  // 1/m at the peak
uniform vec3 u_ozone_k;           // m^2: k where the tent begins, peaks and ends
uniform vec3 u_ozone_ramps;       // 1/m^2: change of its slope over k there
#ifdef HAS_CURVED_OZONE
uniform vec3 u_ozone_altitude;    // m: there; u_ozone_ramps is 1/m, over the altitude
#endif
#endif

// Relative densities (molecules, aerosols) at an altitude [m]; below the ground they stay what they are on it.
vec2 densities(float altitude) {
#ifdef HAS_NO_AEROSOLS
  return vec2(exp(-max(altitude, 0.0) * u_falloff.x), 0.0);  // the constant lets the driver drop what it multiplies
#else
  return exp(-max(altitude, 0.0) * u_falloff);
#endif
}

// Optical depth (3 channels) of columns [m at altitude 0]: molecules, aerosols, and ozone [m at its peak].
vec3 optical_depth(vec3 columns) {
  vec3 tau = u_rayleigh_scattering * columns.x + u_mie_extinction * columns.y;
#ifdef HAS_OZONE
  tau += u_ozone_extinction * columns.z;
#endif
  // Columns summed over few nodes may dip a little below zero; in very thick air exp would make infinity of that.
  return max(tau, -1.0);
}
