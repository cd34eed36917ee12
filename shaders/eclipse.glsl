// How much of the sun the moons leave at a point: limb-darkened discs, by a small table for each moon.
//
// In units of the sun's angular radius a moon has the radius k and the separation delta. The visible fraction is 1 beyond
// delta = 1 + k and constant below delta = k - 1, so a row of the table (one k) runs over what lies between; its rows cover
// the values of k that occur in the air. Moons that overlap in front of the sun count as if they did not.

uniform vec4 u_sun_sphere;               // m: center, radius
uniform vec4 u_occluders[OCCLUDERS];     // m: center, radius
uniform vec2 u_occluder_k[OCCLUDERS];    // smallest k of the rows, 1 / (largest - smallest)
uniform sampler2D u_visibility;          // delta across, k down, one block of rows after the other

vec3 eclipse_base;       // m, base point of the ray whose points are asked for; set by the caller
vec3 eclipse_direction;

// Angle [rad] whose sine is given. The builtin is off by percents of small angles on some drivers.
float arc_sine(float sine) {
  float square = sine * sine;
  return sine < 0.2 ? sine * (1.0 + square * (1.0 / 6.0 + 0.075 * square)) : atan(sine, sqrt(max(1.0 - square, 0.0)));
}

float visible_fraction(vec3 point, int index) {
  vec3 to_sun = u_sun_sphere.xyz - point;
  vec3 to_body = u_occluders[index].xyz - point;
  float far = length(to_sun);
  float near = length(to_body);
  float sun_angle = arc_sine(u_sun_sphere.w / far);
  float k = arc_sine(min(u_occluders[index].w / near, 1.0)) / sun_angle;
  float delta = 2.0 * arc_sine(0.5 * length(to_sun / far - to_body / near)) / sun_angle;
  float low = max(k - 1.0, 0.0);
  vec2 unit = clamp(vec2((delta - low) / (1.0 + k - low), (k - u_occluder_k[index].x) * u_occluder_k[index].y), 0.0, 1.0);
  vec2 texel = unit * vec2(VISIBILITY_COLUMNS - 1, VISIBILITY_ROWS - 1) + vec2(0.5, 0.5 + index * VISIBILITY_ROWS);
  float fraction = texture(u_visibility, texel / vec2(VISIBILITY_COLUMNS, VISIBILITY_ROWS * OCCLUDERS)).x;
  return near >= far ? 1.0 : fraction;
}

// Fraction of the sun's light that passes all moons.
float sun_visibility(vec3 point) {
  float hidden = 0.0;
  for (int i = 0; i < OCCLUDERS; ++i) hidden += 1.0 - visible_fraction(point, i);
  return max(1.0 - hidden, 0.0);
}

float visibility_along(float t) { return sun_visibility(eclipse_base + t * eclipse_direction); }
