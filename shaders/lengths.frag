#version 330 core
// Path lengths of one ray per fragment inside the cones of one body.

#include "shadow.glsl"

uniform sampler2D u_ray;     // x, k, tangent_k, t_end from the base point
uniform sampler2D u_axis;    // z, dz, across, drift
uniform sampler2D u_limits;  // impact, rim
uniform Cone u_umbra;
uniform Cone u_antumbra;
uniform Cone u_outer;

layout(location = 0) out vec4 out_lengths;  // m: umbra, antumbra, penumbra without both, 0

float clipped_length(vec2 interval, float end) {
  float from = clamp(interval.x, 0.0, end);
  return clamp(interval.y, from, end) - from;
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  float end = texelFetch(u_ray, texel, 0).w;
  vec4 b = texelFetch(u_axis, texel, 0);
  vec4 c = texelFetch(u_limits, texel, 0);
  AxisRay axis = AxisRay(b.x, b.y, b.z, b.w, c.x, c.y);
  float umbra = clipped_length(cone_interval(axis, u_umbra, 1.0), end);
  float antumbra = clipped_length(cone_interval(axis, u_antumbra, -1.0), end);
  float outer = clipped_length(cone_interval(axis, u_outer, 1.0), end);
  out_lengths = vec4(umbra, antumbra, max(outer - umbra - antumbra, 0.0), 0.0);
}
