// Mapping of the table of skylight over the sun's height: texels crowd where the sun is near the horizon.

uniform vec2 u_irradiance_mapping;  // width w of the crowded part, lowest mu_s
uniform float u_irradiance_texels;

float arsinh_of(float z) { return sign(z) * log(abs(z) + sqrt(z * z + 1.0)); }

// Cosine of the sun's zenith angle at the center of a texel.
float irradiance_sun_height(float texel) {
  float low = arsinh_of(u_irradiance_mapping.y / u_irradiance_mapping.x);
  float high = arsinh_of(1.0 / u_irradiance_mapping.x);
  float u = mix(low, high, (texel - 0.5) / (u_irradiance_texels - 1.0));
  return clamp(u_irradiance_mapping.x * 0.5 * (exp(u) - exp(-u)), -1.0, 1.0);
}

float irradiance_coordinate(float mu_s) {
  float low = arsinh_of(u_irradiance_mapping.y / u_irradiance_mapping.x);
  float high = arsinh_of(1.0 / u_irradiance_mapping.x);
  float unit = clamp((arsinh_of(mu_s / u_irradiance_mapping.x) - low) / (high - low), 0.0, 1.0);
  return (unit * (u_irradiance_texels - 1.0) + 0.5) / u_irradiance_texels;
}
