// How much of the sun moons and rings leave at a point: limb-darkened discs, by a small table for each moon.
//
// In the plane through the point across the sun's direction a moon casts the image of the sun's disc, of radius `blur`,
// around every point of its own outline, of radius `size`, both drawn from the sun's center; they and the shadow's
// center are linear in the height z above the planet's terminator plane. With q the distance from that center the
// visible fraction is 1 beyond q = size + blur and constant below q = size - blur: a row of the table (one z) runs over
// what lies between. Moons that look large (WIDE) are not flat: angles stand for lengths there, and rows for ratios k.
// Where moons overlap in front of the sun, a map over the plane holds what the sum of their parts counts twice.

uniform mat3 u_sun_axes;         // columns: two axes across the sun's direction and the direction
#ifdef HAS_MOON_TABLES
uniform sampler2D u_visibility;  // across the penumbra, down z or k; one block of rows for each moon
#endif
#ifdef HAS_NARROW_MOONS
uniform vec4 u_moon_path[NARROW_MOONS];   // m: shadow's center at z = 0, its change with z
uniform vec4 u_moon_width[NARROW_MOONS];  // m: blur at z = 0, its change with z, size at z = 0, its change with z
uniform vec2 u_moon_rows;                 // m, 1/m: lowest z of the rows, rows per height
#endif
#ifdef HAS_WIDE_MOONS
uniform vec4 u_sun_sphere;             // m: center in the sun's frame, radius
uniform vec4 u_wide_moons[WIDE_MOONS]; // m: center in the sun's frame, radius
uniform vec4 u_wide_rows[WIDE_MOONS];  // row of a ratio: x + y k up to k = 1, z - w / k beyond; one row is at 1
#endif
#ifdef HAS_RINGS
uniform vec4 u_ring_planes[RINGS];    // unit normal in the sun's frame, its product with the center [m]
uniform vec3 u_ring_centers[RINGS];   // m
uniform vec3 u_ring_edges[RINGS];     // m: inner and outer radius; share of the light that the ring takes
uniform vec4 u_chord;                 // coefficients of the light beyond a chord of the sun's disc
uniform vec2 u_ring_sun;              // m: distance and radius of the sun
#endif
#ifdef HAS_OVERLAPS
uniform sampler2D u_overlaps;  // light that the sum of the moons takes twice; layers of z, one below the other
uniform vec3 u_overlap_low;    // m, corner of the map in the sun's frame
uniform vec3 u_overlap_scale;  // 1/m
#endif

#ifdef HAS_MOON_TABLES
// The table at a place across the penumbra, 0..1, and at a row of it: one fetch of a cell's bilinear form.
float visibility_row(float across, float row) {
  vec2 place = vec2(clamp(across, 0.0, 1.0) * float(VISIBILITY_COLUMNS), row);
  ivec2 cell = ivec2(place);
  vec4 form = texelFetch(u_visibility, cell, 0);
  vec2 inside = place - vec2(cell);
  return form.x + inside.x * form.y + inside.y * (form.z + inside.x * form.w);
}
#endif

#ifdef HAS_NARROW_MOONS
// The moon's disc before the sun at a point p of the sun's frame: blur, size, and the vector from it to p [m].
vec4 narrow_moon(vec3 p, int index) {
  vec4 path = u_moon_path[index];
  vec4 width = u_moon_width[index];
  return vec4(width.xz + p.z * width.yw, p.xy - (path.xy + p.z * path.zw));
}

float narrow_fraction(vec3 p, int index) {
  vec4 moon = narrow_moon(p, index);
  float across = (length(moon.zw) - max(moon.y - moon.x, 0.0)) / (moon.x + min(moon.x, moon.y));
  return visibility_row(across, (p.z - u_moon_rows.x) * u_moon_rows.y + float(index * NARROW_ROWS));
}
#endif

#ifdef HAS_WIDE_MOONS
// Angle [rad] whose sine is given. The builtin is off by percents of small angles on some drivers.
float arc_sine(float sine) {
  float square = sine * sine;
  return sine < 0.2 ? sine * (1.0 + square * (1.0 / 6.0 + 0.075 * square)) : atan(sine, sqrt(max(1.0 - square, 0.0)));
}

// Position and radius of a moon's disc before the sun at a point p of the sun's frame, in units of the sun's radius.
vec3 wide_moon(vec3 p, int index) {
  vec3 to_sun = u_sun_sphere.xyz - p;
  vec3 to_body = u_wide_moons[index].xyz - p;
  float far = length(to_sun);
  float near = length(to_body);
  float sun_angle = arc_sine(u_sun_sphere.w / far);
  float k = arc_sine(min(u_wide_moons[index].w / near, 1.0)) / sun_angle;
  float delta = 2.0 * arc_sine(0.5 * length(to_sun / far - to_body / near)) / sun_angle;
  vec2 aside = to_body.xy - to_sun.xy * (to_body.z / to_sun.z);
  if (near <= u_wide_moons[index].w) return vec3(0.0, 0.0, 2.0 * k);  // inside it nothing is left
  return near >= far ? vec3(1.0e6, 0.0, k) : vec3(aside * (delta / max(length(aside), 1.0e-20)), k);
}

float wide_fraction(vec3 p, int index) {
  vec3 moon = wide_moon(p, index);
  float low = max(moon.z - 1.0, 0.0);
  float across = (length(moon.xy) - low) / (1.0 + moon.z - low);
  vec4 rows = u_wide_rows[index];
  float row = clamp(moon.z < 1.0 ? rows.x + rows.y * moon.z : rows.z - rows.w / moon.z, 0.0, float(WIDE_ROWS - 1));
  return visibility_row(across, row + float(VISIBILITY_ROWS - (WIDE_MOONS - index) * WIDE_ROWS));
}
#endif

#ifdef HAS_OVERLAPS
// Light that two or more moons hide together, counted once for each but the first.
float overlap(vec3 p) {
  vec3 unit = (p - u_overlap_low) * u_overlap_scale;
  vec2 texel = 0.5 + clamp(unit.xy, 0.0, 1.0) * float(OVERLAP_TEXELS - 1);
  float layer = clamp(unit.z, 0.0, 1.0) * float(OVERLAP_LAYERS - 1);
  float first = min(floor(layer), float(OVERLAP_LAYERS - 2));
  vec2 size = vec2(OVERLAP_TEXELS, OVERLAP_TEXELS * OVERLAP_LAYERS);
  float low = texture(u_overlaps, vec2(texel.x, texel.y + first * float(OVERLAP_TEXELS)) / size).x;
  float high = texture(u_overlaps, vec2(texel.x, texel.y + (first + 1.0) * float(OVERLAP_TEXELS)) / size).x;
  return mix(low, high, layer - first);
}
#endif

#ifdef HAS_RINGS
// Share of the sun's light beyond a chord of its disc, s radii from the center.
float beyond_chord(float s) {
  s = clamp(s, -1.0, 1.0);
  float q = s * s;
  return 0.5 - s * (u_chord.x + q * (u_chord.y + q * (u_chord.z + q * u_chord.w)));
}

// Share of the light that passes a ring: its edges cut the sun's disc along chords.
float ring_visibility(vec3 p, int index) {
  vec4 plane = u_ring_planes[index];
  vec3 edges = u_ring_edges[index];
  float inverse = 1.0 / (u_ring_sun.x - p.z);
  vec3 to_sun = vec3(-p.xy * inverse, 1.0);
  float slant = 1.0 / dot(plane.xyz, to_sun);
  float path = (plane.w - dot(plane.xyz, p)) * slant;
  vec3 offset = p + path * to_sun - u_ring_centers[index];
  float radius = max(length(offset), 1.0e-3);
  vec3 outward = offset / radius;
  vec3 rise = outward - plane.xyz * (dot(outward, to_sun) * slant);
  float sharpness = 1.0 / max(path * u_ring_sun.y * inverse * length(rise), 1.0e-3);
  float covered = beyond_chord((edges.x - radius) * sharpness) - beyond_chord((edges.y - radius) * sharpness);
  return path > 0.0 ? 1.0 - edges.z * covered : 1.0;
}
#endif

// Fraction of the sun's light that passes all moons and rings at a point p of the sun's frame.
float visibility_at(vec3 p) {
  float hidden = 0.0;
  float least = 1.0;
#ifdef HAS_NARROW_MOONS
  for (int i = 0; i < NARROW_MOONS; ++i) {
    float fraction = narrow_fraction(p, i);
    hidden += 1.0 - fraction;
    least = min(least, fraction);
  }
#endif
#ifdef HAS_WIDE_MOONS
  for (int i = 0; i < WIDE_MOONS; ++i) {
    float fraction = wide_fraction(p, i);
    hidden += 1.0 - fraction;
    least = min(least, fraction);
  }
#endif
#ifdef HAS_OVERLAPS
  hidden -= overlap(p);
#endif
  float visible = clamp(1.0 - hidden, 0.0, least);
#ifdef HAS_RINGS
  for (int i = 0; i < RINGS; ++i) visible *= ring_visibility(p, i);
#endif
  return visible;
}

// The same at a planet-centered point [m].
float sun_visibility(vec3 point) { return visibility_at(point * u_sun_axes); }
