#version 330 core
// Pass 3: color and depth of the planet, where the ray meets the ground's sphere.

#include "depth.glsl"
#ifdef HAS_SURFACE
#include "surface.glsl"
#endif

uniform vec3 u_camera_up;      // unit vector from the planet's center to the camera
uniform float u_camera_radius; // m

layout(location = 0) out vec4 out_color;

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  Ray ray = pixel_ray(pixel);
  float ground = ground_distance(ray);
  if (ray.air < 0.0 || ground < 0.0) discard;
  float distance = ray.start + ground;
  gl_FragDepth = encode_depth(distance / pixel.stretch);
  out_color = vec4(0.0, 0.0, 0.0, 1.0);
#ifdef HAS_SURFACE
  vec3 up = normalize(u_camera_up * u_camera_radius + distance * pixel.direction);
  out_color.rgb = ground_radiance(up, 0.0, -pixel.direction, distance);
#endif
}
