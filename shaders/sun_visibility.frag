#version 330 core
// What is left of the sun on the surfaces of a host's depth buffer: moons, rings, and the planet's shadow.

#include "depth.glsl"
#include "sunlit.glsl"

uniform Axis u_shadow_axis;
uniform vec3 u_camera_position;  // m

out vec4 out_visibility;

void main() {
  Pixel pixel = make_pixel(gl_FragCoord.xy);
  float distance = host_distance(ivec2(gl_FragCoord.xy), pixel);
  Ray ray = pixel_ray(pixel);
  vec3 off = u_shadow_axis.off + distance * cross(pixel.direction, u_shadow_axis.direction);
  float z = u_shadow_axis.z + distance * dot(pixel.direction, u_shadow_axis.direction);
  bool shadowed = z > 0.0 && dot(off, off) < u_bottom_radius * u_bottom_radius;
  vec3 point = u_camera_position + distance * pixel.direction;
  float visible = visible_sun(point, k_along(ray, distance - ray.start), -z, shadowed);
  out_visibility = vec4(distance < NOTHING ? visible : 1.0, 0.0, 0.0, 1.0);
}
