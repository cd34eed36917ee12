#version 330 core
// Pass 3, geometry near the ground: the displaced relief before the sphere.

#include "depth.glsl"

in vec3 v_relative;

layout(location = 0) out float out_distance;  // m, along the ray

void main() {
  out_distance = length(v_relative);
  gl_FragDepth = encode_depth(out_distance / make_pixel(gl_FragCoord.xy).stretch);
}
