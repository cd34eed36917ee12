#version 330 core
// Pass 3, light: the surface at the distance that the geometry found, once for every pixel that shows it.

#include "surface.glsl"

#ifdef HAS_GEOMETRY
uniform sampler2D u_planet_distance;  // m, along the ray; 0 where the planet is not in view
#endif
uniform vec3 u_camera_up;             // unit vector from the planet's center to the camera
uniform float u_camera_radius;        // m

out vec4 out_color;

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
#ifdef HAS_GEOMETRY
  float distance = texelFetch(u_planet_distance, ivec2(gl_FragCoord.xy), 0).x;
#else
  Ray ray = pixel_ray(pixel);
  float ground = ground_distance(ray);
  float distance = ray.air >= 0.0 && ground >= 0.0 ? max(ray.start + ground, 1.0e-6) : 0.0;
#endif
  vec3 up = normalize(u_camera_up * u_camera_radius + distance * pixel.direction);
  out_color = distance > 0.0 ? vec4(ground_radiance(up, -pixel.direction, distance), 1.0) : vec4(0.0);
}
