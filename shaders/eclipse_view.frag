#version 330 core
// The table of eclipse_view.glsl: the source with and without the moons by the same nodes along a path.

#include "shadow_axis.glsl"
#include "eclipse_multiple_path.glsl"
#include "eclipse_view.glsl"

uniform vec3 u_camera_position;  // m

out vec4 out_ratio;

void main() {
  float slice = floor(gl_FragCoord.y / u_cells_size.y);
  vec2 texel = gl_FragCoord.xy - vec2(0.0, slice * u_cells_size.y);
  Pixel pixel = make_pixel((texel - u_cells.zw) / u_cells.xy);
  Ray ray = pixel_ray(pixel);
  vec3 direction = pixel.direction;
  vec3 base = base_point(pixel, ray, u_camera_position);
#ifdef HAS_HIGH_CELLS
  if (ray.air < 0.0) {
    // What the nearest ray sees that does not miss, for the pixels between the two.
    float altitude = 0.5 * u_thickness;
#ifdef HAS_FAR_CAMERA
    vec3 closest = cross(direction, pixel_moment(pixel));
#else
    vec3 closest = u_camera_position - min(dot(u_camera_position, direction), 0.0) * direction;
#endif
    closest *= (u_bottom_radius + altitude) / length(closest);
    direction = normalize(closest - u_camera_position);
    ray = make_ray(dot(u_camera_position, direction), u_camera_k, altitude * (2.0 * u_bottom_radius + altitude));
#ifdef HAS_FAR_CAMERA
    base = closest + ray.x * direction;
#else
    base = u_camera_position + ray.start * direction;
#endif
  }
#endif
  float nu = clamp(-dot(direction, u_shadow_axis.direction), -1.0, 1.0);
  vec2 sun = vec2(-dot(base, u_shadow_axis.direction), nu);
  float far = max(cell_end(ray, slice), 1.0);
  eclipse_base = base;
  eclipse_direction = direction;
  vec3 kernel = aureole_kernel(nu);
  SinhMap map = make_map(ray, 0.0, far);
  vec2 steps[NODE_COUNT];
  float t[NODE_COUNT];
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 node = map_node(map, NODES[i]);
    t[i] = node.x;
    steps[i] = node.y * densities(altitude_of(k_along(ray, node.x)));
  }
  vec3 without = vec3(1.0e-30);
  vec3 with = vec3(1.0e-30);
  // As in segments.glsl, which ends with the far end where nothing is lit.
  vec2 seen = vec2(sun_visibility(eclipse_base + far * direction), 1.0) * 1.0e-6;
  for (int i = 0; i < u_node_count; ++i) {
    vec2 columns = vec2(0.0);
    for (int j = 0; j < NODE_COUNT; ++j) columns += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
    vec3 clear = WEIGHTS[i] * clearness(ray, columns, t[i]);
    float k = k_along(ray, t[i]);
    float y = sun.x + sun.y * t[i];
    bool lit = y >= 0.0 || k >= y * y;
    vec3 sun_columns = columns_to_top(k, y);
    vec3 light = lit ? exp(-optical_depth(sun_columns)) : vec3(0.0);
    vec3 aureole = aureole_source(steps[i].y, y / (u_bottom_radius + altitude_of(k)), light, sun_columns.y, kernel);
    vec3 source, shaded;
    shaded_source(ray, sun, t[i], steps[i], aureole, -1, source, shaded);
    without += clear * source;
    with += clear * shaded;
    float weight = lit ? clear.y * light.y * (steps[i].x + steps[i].y) + LEAST_LIGHT : 0.0;
    seen += weight * vec2(sun_visibility(eclipse_base + t[i] * direction), 1.0);
  }
  out_ratio = vec4(log(max(with / without, 1.0e-9)) - log(shade(mean_visibility(seen))), 1.0);
}
