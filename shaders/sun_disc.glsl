// The sun's disc, limb-darkened, anti-aliased over one pixel, and the moons' dark discs before it.

uniform vec3 u_sun_disc;      // sine of the angular radius, limb darkening u, radiance at the center [1/sr] per irradiance
uniform vec3 u_sun_toward;    // unit vector from the camera to the sun's center
uniform float u_pixel_angle;  // rad, of a pixel in the middle of the frame

#ifdef HAS_MOONS
uniform vec4 u_moons[MOONS];  // unit vector from the camera, sine of the angular radius

// How much of a pixel the moons hide.
float behind_moons(vec3 direction) {
  float hidden = 0.0;
  for (int i = 0; i < MOONS; ++i) {
    float inside = clamp((u_moons[i].w - length(cross(direction, u_moons[i].xyz))) / u_pixel_angle + 0.5, 0.0, 1.0);
    hidden = max(hidden, dot(direction, u_moons[i].xyz) > 0.0 ? inside : 0.0);
  }
  return hidden;
}
#endif

// Radiance [1/sr] per unit irradiance seen in a direction.
// What is hidden of a pixel at the disc's edge is taken from the disc's part first: totality lets nothing through.
float sun_disc(vec3 direction, float hidden) {
  float sine = length(cross(direction, u_sun_toward));
  float r = sine / u_sun_disc.x;
  float intensity = 1.0 - u_sun_disc.y * (1.0 - sqrt(max(1.0 - r * r, 0.0)));
  float coverage = clamp((u_sun_disc.x - sine) / u_pixel_angle + 0.5, 0.0, 1.0);
  return dot(direction, u_sun_toward) > 0.0 ? u_sun_disc.z * intensity * max(coverage - hidden, 0.0) : 0.0;
}
