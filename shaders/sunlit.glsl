// What a surface sees of the sun past moons, rings and the planet: the twin is shadowatmo/sunlit.py.

#ifdef HAS_TERMINATOR_MOONS
#include "terminator_moons.glsl"
#else
#ifdef HAS_TERMINATOR
#include "limb.glsl"
#endif
#ifdef HAS_ECLIPSE
#include "visibility.glsl"
#endif
#endif

// Fraction of the sun's light at a planet-centered point [m], with its k [m^2], its height y [m] above the terminator
// plane, and whether it lies in the shadow of a sun whose light is parallel.
float visible_sun(vec3 point, float k, float y, bool shadowed) {
#ifdef HAS_TERMINATOR
  float visible = disc_share(disc_above_horizon(k, y));
#else
  float visible = shadowed ? 0.0 : 1.0;
#endif
#ifdef HAS_ECLIPSE
  float passing = sun_visibility(point);
#ifdef HAS_TERMINATOR_MOONS
  passing = disc_visibility(point * u_sun_axes, passing, k, y, vec2(1.0, 0.0)).x;
#endif
  visible *= passing;
#endif
  return visible;
}
