// The part of a sun's disc above the horizon of a sphere. The disc is planar, the horizon straight over it.

#include "ray.glsl"

uniform float u_sun_angle;  // rad, angular radius of the disc

struct Disc {
  float height;   // m, r cos(theta) of its center
  float across;   // m, r sin(theta)
  float visible;  // part of the diameter above the horizon
  float root;     // sqrt(1 - visible)
};

// The sine of the elevation above the local horizon is (R y + sqrt(k) a) / r^2, a = sqrt(r^2 - y^2). Where y < 0 the terms
// cancel, and (k - y^2) / (sqrt(k) a - R y) is the same.
Disc disc_above_horizon(float k, float y) {
  float r = u_bottom_radius + altitude_of(k);
  Disc disc;
  disc.height = y;
  disc.across = safe_sqrt((r - y) * (r + y));
  float lift = safe_sqrt(k) * disc.across;
  float sine = y < 0.0 ? (k - y * y) / (lift - u_bottom_radius * y) : (lift + u_bottom_radius * y) / (r * r);
  // arcsine of small angles; a larger one is cut off anyway
  float square = min(sine * sine, 1.0);
  float elevation = sine * (1.0 + square * (1.0 / 6.0 + 0.075 * square));
  disc.visible = clamp(0.5 + 0.5 * elevation / u_sun_angle, 0.0, 1.0);
  disc.root = sqrt(1.0 - disc.visible);
  return disc;
}

// Share of a uniform disc's light that comes from above the horizon.
float disc_share(Disc disc) {
  float rise = sqrt(disc.visible);
  float half_arc = 2.0 * atan(rise, disc.root);
  return clamp((half_arc - (1.0 - 2.0 * disc.visible) * 2.0 * rise * disc.root) / 3.14159265, 0.0, 1.0);
}
