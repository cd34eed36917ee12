#version 330 core
// Where the pixel's ray is inside the shadow cones of one body: distances [m] from the camera, 0 and 0 for nowhere.

#include "camera.glsl"

uniform Axis u_cone_axis;      // through the body's center, which is the origin of its lengths
uniform float u_body_radius;   // m
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

// A ray seen from an axis that need not pass through the planet's center.
AxisRay body_axis_ray(Pixel pixel, Ray ray) {
  vec3 normal = cross(pixel.direction, u_cone_axis.direction);
  vec3 off = u_cone_axis.off + ray.start * normal;
  float rho = length(off);
  AxisRay result;
  result.dz = dot(pixel.direction, u_cone_axis.direction);
  result.z = u_cone_axis.z + ray.start * result.dz;
  result.across = dot(normal, normal);
  result.drift = dot(off, normal);
  result.impact = dot(off, cross(u_cone_axis.direction, normal));
  result.rim = (rho - u_body_radius) * (rho + u_body_radius);
  return result;
}

vec2 cone_distances(AxisRay axis, Cone cone, float nappe, float start) {
  vec2 inside = cone_interval(axis, cone, nappe) + start;
  inside = vec2(max(inside.x, 0.0), min(inside.y, FAR_AWAY));
  return inside.x < inside.y ? inside : vec2(0.0);
}

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  AxisRay axis = body_axis_ray(pixel, ray);
  out_outer = cone_distances(axis, u_outer, 1.0, ray.start);
#ifdef HAS_UMBRA
  out_umbra = cone_distances(axis, u_umbra, 1.0, ray.start);
#endif
#ifdef HAS_ANTUMBRA
  out_antumbra = cone_distances(axis, u_antumbra, -1.0, ray.start);
#endif
}
