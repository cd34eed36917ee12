"""Float64 twin of shaders/water.glsl: how a wind-roughened sea reflects sun and sky.

Slopes are isotropic and Gaussian (Cox and Munk 1954: variance 0.003 + 0.00512 times the wind speed in m/s), the mirror
follows Fresnel by Schlick's approximation (Elek 2009, eq. 18 is of this kind), masking is Smith's with the rational fit
of Walter et al. 2007.
"""

import numpy as np

WIND_SPEED = 7.0  # m/s
SLOPE_VARIANCE = 0.003 + 0.00512 * WIND_SPEED
NORMAL_REFLECTANCE = 0.02  # of water, refractive index 1.33


def fresnel(cosine):
    """Return the reflectance of water at an angle of incidence given by its cosine, in 0..1."""
    return NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * (1.0 - cosine) ** 5


def masking(cosine):
    """Return Smith's Lambda of a direction at a zenith angle given by its cosine, > 0."""
    a = cosine / np.sqrt(np.maximum(SLOPE_VARIANCE * (1.0 - cosine * cosine), 1e-12))
    return np.where(a < 1.6, (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0.0)


def glint(mu, mu_s, nu):
    """Return the radiance of the reflected sun per unit irradiance on a plane that faces it [1/sr].

    mu, mu_s : cosines of the zenith angles of the eye and the sun, > 0; nu : cosine between the two directions.
    """
    half = np.sqrt(np.maximum(0.5 * (1.0 + nu), 1e-6))  # cosine of the angle of incidence on the mirroring facet
    facet = (mu + mu_s) / (2.0 * half)  # cosine of the facet's own tilt
    tangent = (1.0 - facet * facet) / (facet * facet)
    density = np.exp(-np.maximum(tangent, 0.0) / SLOPE_VARIANCE) / (np.pi * SLOPE_VARIANCE)
    seen = 1.0 / (1.0 + masking(mu) + masking(mu_s))
    return fresnel(half) * density * seen / (4.0 * mu * facet**4)
