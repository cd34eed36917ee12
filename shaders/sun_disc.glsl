// The sun's disc, limb-darkened, anti-aliased over one pixel.

uniform vec3 u_sun_disc;      // sine of the angular radius, limb darkening u, radiance at the center [1/sr] per irradiance
uniform float u_pixel_angle;  // rad, of a pixel in the middle of the frame

// Radiance [1/sr] per unit irradiance seen at an angle from the sun's center given by its sine and cosine.
float sun_disc(float sine, float cosine) {
  float r = sine / u_sun_disc.x;
  float intensity = 1.0 - u_sun_disc.y * (1.0 - sqrt(max(1.0 - r * r, 0.0)));
  float coverage = clamp((u_sun_disc.x - sine) / u_pixel_angle + 0.5, 0.0, 1.0);
  return cosine > 0.0 ? u_sun_disc.z * intensity * coverage : 0.0;
}
