#version 330 core
// The table of multiple_view.glsl: a mean along a path by quadrature, the same nodes for source and extinction.

#include "camera.glsl"
#include "multiple_path.glsl"
#include "multiple_view.glsl"
#ifdef HAS_ECLIPSE_VIEW
#include "eclipse_view.glsl"
#endif

uniform Axis u_shadow_axis;

#ifdef HAS_SUN_COLUMNS
const float REACH = 1.25;  // of cos(azimuth) in texels that no ray has, for their neighbors' sake
#endif

out vec4 out_mean;

void main() {
  float slice = floor(gl_FragCoord.y / u_view_size.y);
  vec2 texel = gl_FragCoord.xy - 0.5 - vec2(0.0, slice * u_view_size.y);
#ifdef HAS_HIGH_CAMERA
  float half_rows = 0.5 * u_view_size.y;
  bool ground = texel.y < half_rows;
  vec2 path = view_ray((texel.y - (ground ? 0.0 : half_rows)) / (half_rows - 1.0), ground, u_camera_k);
  Ray ray = make_ray(path.x, u_camera_k, path.y);
  float mu = path.x / u_view_top.z;
  float mu_s = -u_shadow_axis.z / u_view_top.z;
  float across = safe_sqrt((u_bottom_radius * u_bottom_radius + path.y) / (u_view_top.z * u_view_top.z) * (1.0 - mu_s * mu_s));
#ifdef HAS_SUN_COLUMNS
  vec2 point = view_point(ray.x, path.y);
  float height = point.y * view_sun(texel.x / (u_view_size.x - 1.0));
  float nu = (height + u_shadow_axis.z) / (ray.start + point.x);
  nu = clamp(nu, mu * mu_s - REACH * across, mu * mu_s + REACH * across);
  vec2 sun = vec2(height - nu * point.x, nu);
#else
  float nu = mu * mu_s + across * cos(PI * texel.x / (u_view_size.x - 1.0));
  vec2 sun = vec2(u_view_top.z * mu_s + ray.start * nu, nu);
#endif
#ifdef HAS_WHOLE_PATHS
  float far = ground ? -ray.x - safe_sqrt(-ray.tangent_k) : ray.air;
#else
  // ends where it comes down to the slice's altitude, or nowhere before the ground or the top
  float unit = 1.0 - slice / LAST_SLICE;
  float h = u_thickness * unit * unit;
  float end_k = min(h * (2.0 * u_bottom_radius + h), ray.k) - ray.tangent_k;
  float far = ray.x < 0.0 && end_k > 0.0 && (h > 0.0 || ground) ? -ray.x - sqrt(end_k) : ray.air;
#endif
  far = max(far, 1.0e-4 * u_thickness);
#else
  Pixel pixel = make_pixel(texel * float(CELL));
  Ray ray = pixel_ray(pixel);
  float nu = -dot(pixel.direction, u_shadow_axis.direction);
  vec2 sun = vec2(-u_shadow_axis.z, nu);
  float far = min(max(slice_distance(slice), 1.0e-3 * u_view_slices.x), ray.air);
#endif
  vec3 kernel = aureole_kernel(nu);
  SinhMap map = make_map(ray, 0.0, far);
  vec2 steps[NODE_COUNT];
  vec2 nodes[NODE_COUNT];
  for (int i = 0; i < NODE_COUNT; ++i) {
    nodes[i] = map_node(map, NODES[i]);
    steps[i] = nodes[i].y * densities(altitude_of(k_along(ray, nodes[i].x)));
  }
  vec3 source = vec3(0.0);
  vec3 extinction = vec3(1.0e-30);
  for (int i = 0; i < NODE_COUNT; ++i) {
    float t = nodes[i].x;
    vec2 columns = vec2(0.0);
    for (int j = 0; j < NODE_COUNT; ++j) columns += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
    vec3 weight = WEIGHTS[i] * clearness(ray, columns, t);
    float k = k_along(ray, t);
    float y = sun.x + sun.y * t;
    float r = u_bottom_radius + altitude_of(k);
    vec3 column = vec3(steps[i], 0.0);
#ifdef HAS_OZONE
    column.z = nodes[i].y * ozone_density(k);
#endif
    vec3 sun_columns = columns_to_top(k, y);
    vec3 light = y < 0.0 && k < y * y ? vec3(0.0) : exp(-optical_depth(sun_columns));
    extinction += weight * optical_depth(column);
    source += weight * node_source(ray, sun, t, steps[i]);
    source += weight * aureole_source(steps[i].y, y / r, light, sun_columns.y, kernel);
  }
  out_mean = vec4(log(max(source / extinction, 1.0e-30)), 1.0);
#ifdef HAS_ECLIPSE_VIEW
  out_mean.rgb += eclipse_remainder(texel * float(CELL), ray, far);  // the pixel multiplies by shade() alone
#endif
}
