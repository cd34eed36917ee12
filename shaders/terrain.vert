#version 330 core
// A polar grid about the point below the camera, displaced by the relief. Vertices are computed relative to the camera,
// so that a grid cell of a metre stays a metre.

#include "maps.glsl"

uniform sampler2D u_relief_map;  // slope to the east, slope to the north, altitude [m], share of sea

in vec2 in_grid;  // ring in 0..1, azimuth in 0..1

uniform mat3 u_local;    // columns: two tangents and the up vector at the camera
uniform mat3 u_view;     // rows right, up, forward, the first two over the tangents of the half angles
uniform float u_camera_altitude;  // m
uniform vec2 u_ring_angles;       // rad: of the first and the last ring

out vec3 v_relative;  // m, camera-relative position in planet axes

void main() {
  float angle = in_grid.x <= 0.0 ? 0.0 : u_ring_angles.x * pow(u_ring_angles.y / u_ring_angles.x, in_grid.x);
  float azimuth = 2.0 * PI * in_grid.y;
  float half_sine = sin(0.5 * angle);
  vec3 local = vec3(sin(angle) * cos(azimuth), sin(angle) * sin(azimuth), 1.0 - 2.0 * half_sine * half_sine);
  float altitude = cubic_texture(u_relief_map, map_coordinates(normalize(u_local * local)), 0.0).z;
  vec3 offset = vec3((u_bottom_radius + altitude) * local.xy,
                     altitude * local.z - u_camera_altitude - 2.0 * u_bottom_radius * half_sine * half_sine);
  v_relative = u_local * offset;
  vec3 eye = u_view * v_relative;
  gl_Position = vec4(eye.xy, 0.0, eye.z);
}
