// What the tables of inscatter share: columns along a path between two of its points, and a table's path cut by the
// planet's shadow. The mapping comes from the file of the table in use.

#include "transmittance.glsl"
#ifdef HAS_TABLE4D
#include "table4d_mapping.glsl"
#endif
#ifdef HAS_TABLE3D
#include "table3d_mapping.glsl"
#endif

// Whether a path ends on the ground: the same answer at every point of it.
bool meets_ground(Ray ray) { return ray.tangent_k < 0.0 && ray.x < 0.0; }

// Columns [m] from distance t to the top, seen along the ray; backward where the ray ends on the ground, so that the
// columns never pass through it. Differences of two of them are columns of a path.
vec3 columns_beyond(Ray ray, float t) {
  float sense = meets_ground(ray) ? -1.0 : 1.0;
  return sense * columns_to_top(k_along(ray, t), sense * (ray.x + t));
}

// Transmittance of a part of a path, given columns_beyond its ends.
vec3 clearness(vec3 near, vec3 far) { return exp(-optical_depth(max(near - far, 0.0))); }
