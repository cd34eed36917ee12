// Phase functions, normalized to 1 over the sphere. nu = cosine of the angle between view ray and sun.

const float PI = 3.14159265358979;

uniform float u_mie_g;

float rayleigh_phase(float nu) { return 3.0 / (16.0 * PI) * (1.0 + nu * nu); }

// Cornette and Shanks 1992, eq. 8. `across` = 1 - nu^2 carried apart: near the sun 1 + g^2 - 2 g nu loses its digits,
// (1 - g)^2 + 2 g (1 - nu) with 1 - nu = across / (1 + nu) does not; of a backward lobe the same with both signs turned.
float mie_phase(float nu, float across) {
  float g = abs(u_mie_g);
  float ahead = u_mie_g < 0.0 ? -nu : nu;
  float one_minus_nu = ahead > 0.0 ? across / (1.0 + ahead) : 1.0 - ahead;
  float base = (1.0 - g) * (1.0 - g) + 2.0 * g * one_minus_nu;
  float scale = 3.0 / (8.0 * PI) * (1.0 - g) * (1.0 + g) / (2.0 + g * g);
  return scale * (1.0 + nu * nu) / (base * sqrt(base));
}
