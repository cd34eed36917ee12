"""Real spherical harmonics about the zenith for fields that are even in the azimuth, and phase functions in them.

Y_lm = polar_basis cos(m azimuth), m >= 0, normalized to 1 over the sphere. A phase function P acts on a field by the
factors lambda_l = 2 pi integral of P P_l dmu on its moments (Funk and Hecke).
"""

import math
from functools import cache

import numpy as np

from shadowatmo.ray import safe_sqrt

AUREOLE_DEGREES = 400  # last degree of the sum over a forward lobe


@cache
def harmonic_indices(degree):
    """Return l and m of the coefficients, each ((degree + 1)(degree + 2)/2,), ordered by m, then l."""
    pairs = [(l, m) for m in range(degree + 1) for l in range(m, degree + 1)]  # noqa: E741
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])


def polar_basis(mu, degree):
    """Return the polar part of the real spherical harmonics, (..., coefficients): Y_lm = polar cos(m azimuth).

    Normalized to 1 over the sphere; the polynomials by the usual recurrence in l.
    """
    mu = np.asarray(mu, np.float64)
    sine = safe_sqrt(1.0 - mu * mu)
    columns = []
    for m in range(degree + 1):
        before, current = np.zeros_like(mu), sine**m * math.prod(range(1, 2 * m, 2))
        for l in range(m, degree + 1):  # noqa: E741
            if l > m:
                step = ((2 * l - 1) * mu * current - (l + m - 1) * before) / (l - m)
                before, current = current, step
            factor = (2 * l + 1) / (4 * np.pi) * math.factorial(l - m) / math.factorial(l + m) * (2 if m else 1)
            columns.append(math.sqrt(factor) * current)
    return np.stack(columns, axis=-1)


@cache
def phase_moments(g, degree):
    """Return lambda_l = 2 pi integral of P P_l dmu, l = 0..degree, of aerosols (Cornette and Shanks), (degree + 1,).

    The function is that of Henyey and Greenstein, whose moments are g^l, times 1 + mu^2 and a constant; mu times a
    series follows from the recurrence of the polynomials.
    """
    moments = float(g) ** np.arange(degree + 3)
    result = 1.5 / (2.0 + g * g) * (moments[: degree + 1] + _times_mu(_times_mu(moments))[: degree + 1])
    result.flags.writeable = False
    return result


def _times_mu(moments):
    """Return the Legendre moments of mu f, one fewer, from those of f."""
    l = np.arange(len(moments) - 1)  # noqa: E741
    before = np.concatenate([[0.0], moments[:-2]])
    return ((l + 1) * moments[1:] + l * before) / (2 * l + 1)


def rayleigh_moments(degree):
    """Return lambda_l of molecules: 1, 0, 0.1, 0, ..."""
    moments = np.zeros(degree + 1)
    moments[0] = 1.0
    if degree >= 2:
        moments[2] = 0.1
    return moments


def band_coefficients(g, band):
    """Return the Legendre series of the aerosols' phase function up to a degree, (band + 1,)."""
    return (2 * np.arange(band + 1) + 1) / (4 * np.pi) * phase_moments(g, band)


def aureole_kernel(g, degree, nu):
    """Return K_j(nu) = sum over l > degree of (2 l + 1)/(4 pi) lambda_l^(j + 1) P_l(nu), j = 1..3, (..., 3) [1/sr]."""
    moments = phase_moments(g, AUREOLE_DEGREES)
    series = (2 * np.arange(len(moments)) + 1)[:, None] / (4 * np.pi) * moments[:, None] ** np.array([2, 3, 4])
    series[: degree + 1] = 0.0
    return np.moveaxis(np.polynomial.legendre.legval(nu, series), 0, -1)
