"""Phase functions: where scattered light goes, normalized to 1 over the sphere [1/sr].

Both take nu, the cosine of the angle between the viewing direction and the direction to the sun; nu = 1 looks
at the sun, which is forward scattering.
"""

import numpy as np


def rayleigh_phase(nu):
    """Return the phase function of molecules without anisotropy, 3/(16 pi) (1 + nu^2).

    Parameters
    ----------
    nu : array_like
        Cosine of the angle between the viewing direction and the direction to the sun.

    Returns
    -------
    ndarray
        [1/sr], shape of `nu`.
    """
    nu = np.asarray(nu, dtype=np.float64)
    return 3.0 / (16.0 * np.pi) * (1.0 + nu * nu)


def mie_phase(nu, g):
    """Return the phase function of aerosols after Cornette and Shanks (1992, Appl. Opt. 31, equation 8).

    Parameters
    ----------
    nu : array_like
        Cosine of the angle between the viewing direction and the direction to the sun.
    g : float
        Asymmetry, in (-1, 1); > 0 scatters forward.

    Returns
    -------
    ndarray
        [1/sr], shape of `nu`.
    """
    nu = np.clip(np.asarray(nu, dtype=np.float64), -1.0, 1.0)
    size, ahead = abs(g), nu if g >= 0 else -nu
    # 1 + g^2 - 2 g nu as a sum of two terms >= 0: the peak of a narrow lobe keeps its digits.
    base = (1.0 - size) ** 2 + 2.0 * size * (1.0 - ahead)
    return 3.0 / (8.0 * np.pi) * (1.0 - g * g) * (1.0 + nu * nu) / ((2.0 + g * g) * base * np.sqrt(base))
