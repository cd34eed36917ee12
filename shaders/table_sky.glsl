// Irradiance of the ground by the sky from the table that goes with a table of inscatter, over the sun's height.

uniform sampler2D u_sky_irradiance_table;

// Per unit solar irradiance; mu_s = cosine of the sun's zenith angle on the ground. sun_axis is the inscatter table's own.
vec3 table_sky_irradiance(float mu_s) {
  vec2 size = vec2(textureSize(u_sky_irradiance_table, 0));
  return texture(u_sky_irradiance_table, vec2(0.5 + sun_axis(mu_s) * (size.x - 1.0), 0.5) / size).rgb;
}
