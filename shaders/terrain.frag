#version 330 core
// Pass 3, near the ground: the displaced relief over the sphere.

#include "depth.glsl"
#include "surface.glsl"

in vec3 v_relative;
in vec3 v_up;
in float v_altitude;

layout(location = 0) out vec4 out_color;

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  vec3 up = normalize(v_up);
  float distance = length(v_relative);
  gl_FragDepth = encode_depth(distance / pixel.stretch);
  out_color = vec4(ground_radiance(up, max(v_altitude, 0.0), -pixel.direction, distance), 1.0);
}
