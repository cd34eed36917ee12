"""Float64 twin of shaders/terminator.glsl: the light of a sun whose disc the planet's limb hides in part.

At a point the disc is planar, uniform, and told by zenith angles alone: a strip at the height y, -1 to 1 in radii
alpha of the disc, has the zenith angle theta - alpha y and the weight (2/pi) sqrt(1 - y^2) dy; strips below the
horizon are dark. With q the visible part of the disc's diameter, 0 to 1, the strips are y = 1 - 2 q v, v the nodes of
the Gauss rule of that weight over the visible part. Nodes, and weights over q^(3/2), are smooth in c = sqrt(1 - q),
and polynomials of c stand for them; for a wholly visible disc (c = 0) they are exact.

What a moon leaves of the part above the horizon is a factor of its own: terminator_moons.py.
"""

import functools

import numpy as np

from shadowatmo.quadrature import gauss_legendre
from shadowatmo.ray import altitude_of, safe_sqrt
from shadowatmo.shadow import Cone, umbra_cone
from shadowatmo.transmittance import transmittance_to_top

DEGREE = 3  # of the polynomials in c: nodes to 0.003, weights to 0.002 of the whole disc
MAX_STRIPS = 4
MEASURE_NODES = 300  # nodes that stand for the continuous weight


def angular_radius(sun) -> float:
    """Return the radius alpha [rad] of a sun's disc as seen from the planet."""
    return float(np.arcsin(sun.radius / sun.distance))


def night_cone(radius, sun) -> Cone:
    """Return where a planet of `radius` [m] hides the whole disc of a sun whose light is parallel.

    It narrows by the disc's angular radius, which is what the umbra of two spheres does where the difference of their
    radii is the sun's own.
    """
    return umbra_cone(radius, sun.radius + radius, sun.distance)


def visible_rule(q, count) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes v and weights (count,) of the Gauss rule over the visible part q of the disc's diameter.

    The weights add up to the visible share of the disc. Stieltjes' procedure on a dense rule in b, y = cos b.
    """
    last = np.arccos(1.0 - 2.0 * q)
    points, weights = gauss_legendre(MEASURE_NODES)
    b = last * points
    measure = 2.0 / np.pi * np.sin(b) ** 2 * weights * last
    v = np.sin(0.5 * b) ** 2 / q
    previous, current, norm_before = np.zeros_like(v), np.ones_like(v), np.inf
    diagonal, off = [], []
    for _ in range(count):
        norm = measure @ (current * current)
        diagonal.append(measure @ (v * current * current) / norm)
        off.append(norm / norm_before)
        previous, current = current, (v - diagonal[-1]) * current - off[-1] * previous
        norm_before = norm
    side = np.diag(np.sqrt(off[1:]), 1)
    nodes, vectors = np.linalg.eigh(np.diag(diagonal) + side + side.T)
    return nodes, vectors[0] ** 2 * measure.sum()


@functools.lru_cache(maxsize=8)
def strip_polynomials(count) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients (DEGREE + 1, count) of powers of c: of v, and of the weights over q^(3/2)."""
    c = 0.5 - 0.5 * np.cos(np.pi * (np.arange(60) + 0.5) / 60.0)
    rules = [visible_rule(1.0 - value * value, count) for value in c]
    nodes = np.array([rule[0] for rule in rules])
    weights = np.array([rule[1] for rule in rules]) / (1.0 - c * c)[:, None] ** 1.5
    powers = c[:, None] ** np.arange(1, DEGREE + 1)
    result = []
    for values, whole in zip((nodes, weights), visible_rule(1.0, count), strict=True):
        rest = np.linalg.lstsq(powers, values - whole, rcond=None)[0]
        result.append(np.vstack([whole, rest]))
    return result[0], result[1]


def elevation_sine(atmosphere, k, y):
    """Return the sine (N,) of the sun's elevation above the local horizon, the ground's sphere.

    With the dip d, sin d = sqrt(k)/r, it is (R y + sqrt(k) a)/r^2, a = sqrt(r^2 - y^2); where y < 0 the two
    terms cancel, and (k - y^2)/(sqrt(k) a - R y) is the same.
    """
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k)
    rho, across = safe_sqrt(k), safe_sqrt((r - y) * (r + y))
    below = np.where(y < 0.0, rho * across - atmosphere.bottom_radius * y, 1.0)
    return np.where(y < 0.0, (k - y * y) / below, (atmosphere.bottom_radius * y + rho * across) / (r * r))


def strips(atmosphere, sun, k, y, count):
    """Return heights y_i = r cos(theta_i) [m] of the strips, their weights, and the angles alpha y above the center.

    All are (N, count); `k` and `y` (N,) belong to the point and to the disc's center.
    """
    alpha = angular_radius(sun)
    sine = np.clip(elevation_sine(atmosphere, k, y), -1.0, 1.0)
    q = np.clip(0.5 + 0.5 * np.arcsin(sine) / alpha, 0.0, 1.0)
    powers = np.sqrt(1.0 - q)[:, None] ** np.arange(DEGREE + 1)
    nodes, weights = (powers @ table for table in strip_polynomials(count))
    angle = alpha * (1.0 - 2.0 * q[:, None] * nodes)
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k)
    across = safe_sqrt((r - y) * (r + y))
    heights = y[:, None] * np.cos(angle) + across[:, None] * np.sin(angle)
    return heights, weights * q[:, None] ** 1.5, angle


def disc_transmittance(atmosphere, sun, k, y, count, terms=6, subtract_top=True):
    """Return the mean transmittance (N, 3) over the disc, its hidden part dark."""
    heights, weights, _ = strips(atmosphere, sun, k, y, count)
    light = transmittance_to_top(atmosphere, k[:, None], heights, terms, subtract_top)
    return np.einsum("ni,nic->nc", weights, light)
