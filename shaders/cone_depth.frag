#version 330 core
// Where the pixel's ray is inside the shadow cones of one body: distances [m] from the camera, 0 and 0 for nowhere.

#include "camera.glsl"

// Through the body, its lengths counted from the point nearest to the planet's center: what is told from a body 4e8 m away
// has lost the digits that count in the air. The cones are those lengths' too.
uniform Axis u_cone_axis;
uniform vec3 u_cone_aside;  // m, that point x direction of the axis
#ifdef HAS_UMBRA
uniform Cone u_umbra;
layout(location = UMBRA_LAYER) out vec2 out_umbra;  // front, back
#endif
#ifdef HAS_ANTUMBRA
uniform Cone u_antumbra;
layout(location = ANTUMBRA_LAYER) out vec2 out_antumbra;
#endif
uniform Cone u_outer;
layout(location = 0) out vec2 out_outer;

// A ray seen from an axis that need not pass through the planet's center; `rim` is each cone's own.
AxisRay aside_axis_ray(Pixel pixel, Ray ray, out float rho) {
  vec3 normal = cross(pixel.direction, u_cone_axis.direction);
  AxisRay result;
  result.dz = dot(pixel.direction, u_cone_axis.direction);
  result.z = base_height(pixel, ray, u_cone_axis, result.dz);
  result.across = dot(normal, normal);
  vec3 off = base_off(pixel, ray, u_cone_axis, result.dz, normal) - u_cone_aside;
  rho = length(off);
  result.drift = dot(off, normal);
  result.impact = dot(off, cross(u_cone_axis.direction, normal));
  return result;
}

vec2 cone_distances(AxisRay axis, float rho, Cone cone, float nappe, float start) {
  axis.rim = (rho - cone.radius) * (rho + cone.radius);
  vec2 inside = cone_interval(axis, cone, nappe) + start;
  inside = vec2(max(inside.x, 0.0), min(inside.y, FAR_AWAY));
  return inside.x < inside.y ? inside : vec2(0.0);
}

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  float rho;
  AxisRay axis = aside_axis_ray(pixel, ray, rho);
  out_outer = cone_distances(axis, rho, u_outer, 1.0, ray.start);
#ifdef HAS_UMBRA
  out_umbra = cone_distances(axis, rho, u_umbra, 1.0, ray.start);
#endif
#ifdef HAS_ANTUMBRA
  out_antumbra = cone_distances(axis, rho, u_antumbra, -1.0, ray.start);
#endif
}
