// Multiple scattering along a ray with and without the moons, at the same nodes.

#include "eclipse_multiple.glsl"
#include "multiple_path.glsl"

uniform int u_node_count;  // NODE_COUNT, which the compiler must not know here: unrolled, these loops take minutes to compile

struct Shaded {
  vec3 without;  // 1/sr
  vec3 with;
  vec2 columns;  // m, of the exponential layers up to where the next piece begins
};

// The source without moons and with them, at a point of a piece. `moon`: one of them alone, or -1 for all.
void shaded_source(Ray ray, vec2 sun, float t, vec2 step, vec3 aureole, int moon, out vec3 without, out vec3 with) {
  float altitude = altitude_of(k_along(ray, t));
  vec3 point = eclipse_base + t * eclipse_direction;
  vec3 mean = multiple_mean(altitude, (sun.x + sun.y * t) / (u_bottom_radius + altitude));
  without = node_source(ray, sun, t, step) + aureole;
#ifdef HAS_ONE_MOON
  with = source_under(without, mean, step, point, eclipse_direction, altitude, moon, visible_fraction(point, moon));
#else
  with = eclipsed_source(without, mean, step, point, eclipse_direction, altitude);
#endif
}

void gather_shaded(Ray ray, vec2 sun, float near, float far, bool lit, vec3 kernel, int moon, inout Shaded sum) {
  SinhMap map = make_map(ray, near, far);
  vec2 steps[NODE_COUNT];
  float t[NODE_COUNT];
  for (int i = 0; i < NODE_COUNT; ++i) {
    vec2 node = map_node(map, NODES[i]);
    t[i] = node.x;
    steps[i] = node.y * densities(altitude_of(k_along(ray, node.x)));
  }
  vec3 without = vec3(0.0);
  vec3 with = vec3(0.0);
  vec3 lost = vec3(0.0);
  for (int i = 0; i < u_node_count; ++i) {
    vec2 columns = sum.columns;
    for (int j = 0; j < NODE_COUNT; ++j) columns += CUMULATIVE[i * NODE_COUNT + j] * steps[j];
    vec3 clear = WEIGHTS[i] * clearness(ray, columns, t[i]);
    lost += clear * optical_depth(vec3(steps[i], 0.0));
    vec3 aureole = vec3(0.0);
#ifdef HAS_AUREOLE
    float k = k_along(ray, t[i]);
    float y = sun.x + sun.y * t[i];
    vec3 sun_columns = columns_to_top(k, y);
    vec3 light = lit ? exp(-optical_depth(sun_columns)) : vec3(0.0);
    aureole = aureole_source(steps[i].y, y / (u_bottom_radius + altitude_of(k)), light, sun_columns.y, kernel);
#endif
    vec3 source, shaded;
    shaded_source(ray, sun, t[i], steps[i], aureole, moon, source, shaded);
    without += clear * source;
    with += clear * shaded;
  }
  vec3 before = clearness(ray, sum.columns, near);
  for (int i = 0; i < NODE_COUNT; ++i) sum.columns += WEIGHTS[i] * steps[i];
  vec3 held = gain(before - clearness(ray, sum.columns, far), lost);
  sum.without += held * without;
  sum.with += held * with;
}

// The whole path; cuts [m] as in segments.glsl.
Shaded gather_shaded(Ray ray, vec2 sun, vec4 cuts, vec3 kernel, int moon) {
  Shaded sum = Shaded(vec3(0.0), vec3(0.0), vec2(0.0));
  for (int i = 0; i < min(u_node_count, 3); ++i) {
    float near = i == 0 ? cuts.x : (i == 1 ? cuts.y : cuts.z);
    float far = i == 0 ? cuts.y : (i == 1 ? cuts.z : cuts.w);
    if (far > near) gather_shaded(ray, sun, near, far, i != 1, kernel, moon, sum);
  }
  return sum;
}
