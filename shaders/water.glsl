// How a wind-roughened sea reflects the sun and the sky: Gaussian slopes (Cox and Munk 1954), Fresnel by Schlick's
// approximation, masking by Smith with the rational fit of Walter et al. 2007.

const float SLOPE_VARIANCE = 0.03884;     // at a wind of 7 m/s
const float NORMAL_REFLECTANCE = 0.02;    // of water

float fresnel(float cosine) {
  float one_minus = 1.0 - cosine;
  float square = one_minus * one_minus;
  return NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * square * square * one_minus;
}

float masking(float cosine) {
  float a = cosine * inversesqrt(max(SLOPE_VARIANCE * (1.0 - cosine * cosine), 1.0e-12));
  return a < 1.6 ? (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) : 0.0;
}

// Radiance [1/sr] of the reflected sun per unit irradiance on a plane that faces it; mu, mu_s > 0.
float glint(float mu, float mu_s, float nu) {
  float half_cosine = sqrt(max(0.5 * (1.0 + nu), 1.0e-6));
  float facet = (mu + mu_s) / (2.0 * half_cosine);
  float square = facet * facet;
  float density = exp(-max(1.0 - square, 0.0) / (square * SLOPE_VARIANCE)) / (3.14159265 * SLOPE_VARIANCE);
  float seen = 1.0 / (1.0 + masking(mu) + masking(mu_s));
  return fresnel(half_cosine) * density * seen / (4.0 * mu * square * square);
}
