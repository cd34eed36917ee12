// A view ray inside the air, in a form that float32 can carry at any distance.
//
// CONVENTIONS for all libraries: lengths in metres, planet-centered. t = distance along the ray counted from its base
// point, which is the camera inside the air and the entry into the shell outside. x = distance from the tangent point
// (where the ray is the nearest to the center), so x = ray.x + t. Instead of a radius r we carry
// k = r^2 - R^2 = h (2 R + h), R = ground radius, h = altitude: it keeps centimeters where r has lost them, and along
// the ray it is a parabola, k(t) = k_base + t (t + 2 x_base).

uniform float u_bottom_radius;  // m
uniform float u_thickness;      // m, altitude of the top of the air
uniform float u_top_k;          // m^2, k of the top

struct Ray {
  float x;          // m, of the base point
  float k;          // m^2, of the base point
  float tangent_k;  // m^2, of the tangent point; negative where the line meets the ground
  float start;      // m, from the camera to the base point
  float air;        // m, from the base point to the exit through the top (ground ignored); negative: misses the air
};

float safe_sqrt(float v) { return sqrt(max(v, 0.0)); }

// Altitude [m] of a point by its k. No difference of radii, so no cancellation. The floor, half way down to the center,
// only keeps the radius of a camera inside the planet away from zero.
float altitude_of(float k) {
  float square = u_bottom_radius * u_bottom_radius;
  return k / (u_bottom_radius + sqrt(max(square + k, 0.25 * square)));
}

float k_along(Ray ray, float t) {
#ifdef HAS_DEEP_SHELL
  // From the top of a shell far deeper than its air the base point's k is so large that it swamps what is near the ground.
  float x = ray.x + t;
  if (ray.k > abs(ray.tangent_k)) return ray.tangent_k + x * x;
#endif
  return ray.k + t * (t + 2.0 * ray.x);
}

// The root of t^2 + 2 x t + c = 0 that lies farther along the ray, where it exists (root = sqrt(x^2 - c)); q-root form.
float far_root(float x, float c, float root) { return x > 0.0 ? -c / (x + root) : root - x; }

// Ray from the camera's quantities: x and k of the camera, tangent_k, all as accurate as the caller can have them.
Ray make_ray(float x, float k, float tangent_k) {
  float half_chord = safe_sqrt(u_top_k - tangent_k);
  Ray ray;
  ray.tangent_k = tangent_k;
  float c = k - u_top_k;
  bool outside = c > 0.0;
  ray.start = outside ? c / max(half_chord - x, 1.0e-30) : 0.0;
  ray.x = outside ? -half_chord : x;
  ray.k = outside ? u_top_k : k;
  ray.air = outside ? 2.0 * half_chord : far_root(x, c, half_chord);
  bool misses = tangent_k >= u_top_k || (c >= 0.0 && x >= 0.0);
  if (misses) {
    ray.start = 0.0;
    ray.air = -1.0;
  }
  return ray;
}

// Distance [m] from the base point to the ground, or a negative number where the ray does not meet it ahead.
float ground_distance(Ray ray) {
  bool hits = ray.tangent_k < 0.0 && ray.x < 0.0;
  return hits ? max(ray.k, 0.0) / (safe_sqrt(-ray.tangent_k) - ray.x) : -1.0;
}
