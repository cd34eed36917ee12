"""The air: densities of its three species, their coefficients, and their columns along straight paths.

Species, in this order: molecules (Rayleigh), aerosols (Mie), ozone. The first two fall exponentially with
altitude, the third is a tent. Densities are relative: 1 at altitude 0, for ozone 1 at the peak. They end
sharply at the top of the air; below altitude 0 they keep their value at 0, so that a point a hair under the
ground is no special case.

A column is the integral of a relative density along a path [m]; times the extinction coefficients it is the
optical depth. It is integrated here by Gauss-Legendre panels whose ends lie on altitudes that double from the
low end of the path, and on the kinks of the tent.
"""

import functools

import numpy as np

from shadowatmo.parameters import Atmosphere

COLUMN_NODES = 12  # per panel; 16 changes no column of the tests by more than 1e-12 of itself
_CHUNK = 2048  # paths at a time: keeps the temporaries near the size of the cache


def extinction(atmosphere: Atmosphere) -> np.ndarray:
    """Return extinction coefficients [1/m] at relative density 1, (3 species, 3 channels)."""
    ozone = (0.0, 0.0, 0.0) if atmosphere.ozone is None else atmosphere.ozone.extinction
    return np.array([atmosphere.rayleigh_scattering, atmosphere.mie_extinction, ozone])


def optical_depth(atmosphere: Atmosphere, columns) -> np.ndarray:
    """Return the optical depth (..., 3 channels) of columns (..., 3 species) [m].

    Columns summed over few nodes may dip a little below zero; never below -1, as exp would make infinity of very
    thick air's.
    """
    return np.maximum(columns @ extinction(atmosphere), -1.0)


def scattering(atmosphere: Atmosphere) -> np.ndarray:
    """Return scattering coefficients [1/m] at relative density 1, (2 species, 3 channels), none of ozone."""
    return np.array([atmosphere.rayleigh_scattering, atmosphere.mie_scattering])


def densities(atmosphere: Atmosphere, altitude) -> np.ndarray:
    """Return relative densities (..., 3 species) at `altitude` (...) [m]; 0 above the top."""
    h = np.asarray(altitude, dtype=np.float64)
    clamped = np.maximum(h, 0.0)
    result = np.zeros((*h.shape, 3))
    np.exp(clamped / -atmosphere.rayleigh_scale_height, out=result[..., 0])
    np.exp(clamped / -atmosphere.mie_scale_height, out=result[..., 1])
    if atmosphere.ozone is not None:
        tent = atmosphere.ozone
        result[..., 2] = np.maximum(0.0, 1.0 - np.abs(clamped - tent.center) / tent.half_width)
    result[h > atmosphere.thickness] = 0.0
    return result


def kink_altitudes(atmosphere: Atmosphere) -> np.ndarray:
    """Return the altitudes inside the air [m] at which a density is not smooth."""
    if atmosphere.ozone is None:
        return np.empty(0)
    tent = atmosphere.ozone
    levels = tent.center + tent.half_width * np.array([-1.0, 0.0, 1.0])
    return levels[(levels > 0.0) & (levels < atmosphere.thickness)]


def altitude_from_power(radius: float, power):
    """Return h = |p| - radius [m] from power = |p|^2 - radius^2 [m^2], without cancellation."""
    return power / (radius + np.sqrt(np.maximum(radius * radius + power, 0.0)))


def path_columns(atmosphere: Atmosphere, power, slope, length, nodes: int = COLUMN_NODES) -> np.ndarray:
    """Return the columns [m] of the three species along straight paths inside the air.

    A path starts at p and runs for `length` along a unit vector w. Two numbers say where it lies: on it, at
    the distance s, |x|^2 - Rb^2 = power + s (s + 2 slope).

    Parameters
    ----------
    power : (N,) float
        |p|^2 - Rb^2, Rb the radius of the ground [m^2].
    slope : (N,) float
        dot(p, w) [m]; negative where the path goes down first.
    length : (N,) float
        [m], >= 0.
    nodes : int
        Gauss-Legendre nodes per panel.

    Returns
    -------
    (N, 3) ndarray
    """
    power, slope, length = np.broadcast_arrays(power, slope, length)
    result = np.empty((power.size, 3))
    for begin in range(0, power.size, _CHUNK):
        part = slice(begin, begin + _CHUNK)
        result[part] = _columns(atmosphere, power[part], slope[part], length[part], nodes)
    return result


def _columns(atmosphere, power, slope, length, nodes):
    """Split the paths at their lowest point and add up both halves, the first one seen from its far end."""
    down = np.clip(-slope, 0.0, length)
    low_power = power + down * (down + 2.0 * slope)
    low = altitude_from_power(atmosphere.bottom_radius, low_power)
    offset = np.maximum(-slope - length, 0.0)  # of the low end from the tangent point of the line
    result = np.zeros((power.size, 3))
    falls = down > 0.0
    if falls.any():
        result[falls] = _ascending(atmosphere, low[falls], offset[falls], down[falls], nodes)
    rises = length > down
    if rises.any():
        beyond = np.maximum(slope, 0.0)[rises]
        result[rises] += _ascending(atmosphere, low[rises], beyond, (length - down)[rises], nodes)
    return result


def _ascending(atmosphere, low, offset, length, nodes):
    """Return columns (N, 3) of rising paths from altitude `low`, `offset` beyond their line's tangent point.

    All distances are carried as differences from the low end, so nothing cancels on grazing paths.
    """
    radius = atmosphere.bottom_radius + low
    rise = _rise(radius, length * (length + 2.0 * offset))
    heights = rise[:, None] * _doubling(atmosphere)
    kinks = kink_altitudes(atmosphere)
    if kinks.size:
        inserted = np.clip(kinks - low[:, None], 0.0, rise[:, None])
        heights = np.sort(np.concatenate([heights, inserted], axis=1), axis=1)
    power = heights * (2.0 * radius[:, None] + heights)
    divisor = offset[:, None] + np.sqrt(offset[:, None] ** 2 + power)
    edges = np.minimum(power / np.where(divisor > 0.0, divisor, 1.0), length[:, None])
    edges[:, -1] = length

    points, weights = unit_gauss(nodes)
    widths = np.diff(edges, axis=1)
    along = (edges[:, :-1, None] + widths[:, :, None] * points).reshape(len(low), -1)
    altitude = low[:, None] + _rise(radius[:, None], along * (along + 2.0 * offset[:, None]))
    weight = (widths[:, :, None] * weights).reshape(len(low), 1, -1)
    return (weight @ densities(atmosphere, altitude))[:, 0, :]


def _rise(radius, power):
    """Return the altitude gained over `radius` where |x|^2 grew by `power`."""
    return power / (radius + np.sqrt(radius * radius + power))


@functools.lru_cache(maxsize=64)
def _doubling(atmosphere: Atmosphere) -> np.ndarray:
    """Return fractions 0, ..., 1/4, 1/2, 1 of a rise; the first panel is within two scale heights."""
    thinnest = min(atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height)
    panels = int(np.clip(np.ceil(np.log2(atmosphere.thickness / thinnest)), 2, 40))
    return np.concatenate([[0.0], 0.5 ** np.arange(panels - 1, -1, -1)])


@functools.lru_cache(maxsize=64)
def unit_gauss(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss-Legendre nodes and weights on [0, 1]."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    return (points + 1.0) / 2.0, weights / 2.0
