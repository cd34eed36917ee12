// Shadow volumes as cones about an axis: the planet's cylinder (a cone of zero slope), umbra, antumbra, penumbra.
//
// A body of radius R at Y, light from the side of -a: z = (P - Y) . a, rho = distance from the axis, and the volume is
// rho <= w(z) = R + excess - z slope on z in [near, far]. umbra: slope = tan phi, excess = R (1/cos phi - 1), sin phi =
// (Rs - R)/D; penumbra: slope = -tan psi, sin psi = (Rs + R)/D. The antumbra is the umbra's other nappe, w < 0.
//
// Along the ray rho^2 - w^2 = A t^2 + 2 B t + C. B^2 - A C cancels where the base point is far from the axis and the ray
// passes close to it; with n = d x a, i the impact of the ray on the axis and u = n^2 w - (dw/dt) drift it also equals
// (u^2 - i^2 A) / n^2, which cancels where the base point is close to the edge. The smaller terms win.

#include "ray.glsl"

// Where the ray runs relative to a shadow axis, at its base point.
struct AxisRay {
  float z;       // m, along the axis
  float dz;      // cos of the angle between ray and axis
  float across;  // squared sine of that angle
  float drift;   // m, half the derivative of rho^2
  float impact;  // m, smallest distance of ray and axis times the sine
  float rim;     // m^2, rho^2 - R^2
};

struct Cone {
  float radius;  // m
  float slope;
  float excess;  // m
  float near;    // m, along the axis
  float far;     // m
};

const float FAR_AWAY = 1.0e30;  // m, stands for infinity where infinity times zero would follow

vec2 ordered(float a, float b) { return vec2(min(a, b), max(a, b)); }

// Values of t at which a + t b lies in [low, high].
vec2 slab_interval(float a, float b, float low, float high) {
  float safe = abs(b) < 1.0e-12 ? (b < 0.0 ? -1.0e-12 : 1.0e-12) : b;
  return ordered((low - a) / safe, (high - a) / safe);
}

// Part of the line (t0, t1) inside the cone's nappe (+1: w > 0, -1: beyond the apex); empty where t0 >= t1.
vec2 cone_interval(AxisRay ray, Cone cone, float nappe) {
  float delta = cone.excess - ray.z * cone.slope;
  float w = cone.radius + delta;
  float dw = -ray.dz * cone.slope;
  float a = ray.across - dw * dw;
  float b = ray.drift - w * dw;
  float c = ray.rim - delta * (2.0 * cone.radius + delta);
  float u = ray.across * w - dw * ray.drift;
  bool parallel = ray.across < 1.0e-13;  // to the axis, as far as float32 can tell
  float safe_across = max(ray.across, 1.0e-30);
  bool near = parallel || b * b * safe_across < u * u;
  float discriminant = near ? b * b - a * c : (u * u - ray.impact * ray.impact * a) / safe_across;

  vec2 slab = slab_interval(ray.z, ray.dz, cone.near, cone.far);
  float root = safe_sqrt(discriminant);
  float q = b >= 0.0 ? -(b + root) : root - b;
  float safe_q = abs(q) < 1.0e-30 ? 1.0e-30 : q;
  float safe_a = abs(a) < 1.0e-20 ? (a < 0.0 ? -1.0e-20 : 1.0e-20) : a;
  vec2 roots = ordered(clamp(q / safe_a, -FAR_AWAY, FAR_AWAY), clamp(c / safe_q, -FAR_AWAY, FAR_AWAY));
  // a > 0: the ray passes through one nappe between the roots. a < 0: it is steeper than the cone and stays inside
  // from a root on, on the side where the nappe opens.
  bool opens_ahead = nappe * dw > 0.0;
  vec2 inside = a > 0.0 ? roots : (opens_ahead ? vec2(roots.y, FAR_AWAY) : vec2(-FAR_AWAY, roots.x));
  vec2 result = vec2(max(inside.x, slab.x), min(inside.y, slab.y));
  float middle = 0.5 * (max(result.x, -FAR_AWAY) + min(result.y, FAR_AWAY));
  bool wrong_nappe = a > 0.0 && nappe * (w + middle * dw) < 0.0;
  bool empty = (a > 0.0 && discriminant <= 0.0) || wrong_nappe;
  if (parallel && cone.slope == 0.0) {  // a cylinder is never entered nor left
    result = slab;
    empty = c >= 0.0;
  }
  return empty ? vec2(FAR_AWAY) : result;
}
