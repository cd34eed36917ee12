"""How much of the sun is to be seen past the moons: limb-darkened discs that overlap.

Sun and occluder are taken for planar discs whose radii and distance are the angles that they have in the sky.
The light that one disc hides is an integral over the overlap; Green's theorem turns it into integrals along
the two arcs that bound it (Pal 2008, MNRAS 390, 281; Agol et al. 2020, AJ 159, 123), which are smooth but for
a 3/2 power at their ends. Several occluders may overlap on the disc, so the light that they hide together is
integrated ring by ring.

Lengths on the disc are in units of the sun's radius: k the radius of the occluder, delta the distance of the
centers. Intensity: I(r) = 1 - u (1 - sqrt(1 - r^2)).
"""

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.medium import unit_gauss
from shadowatmo.parameters import Occluder, Sun
from shadowatmo.rays import Rays
from shadowatmo.ring import ring_chords, ring_visibility
from shadowatmo.scene import Scene

ARC_NODES = 40  # error below 1e-8 of the sun's light, worst at grazing contacts
RING_NODES = 24  # per piece between kinks
_CHUNK = 1024
_HALF_PLANE = 1e6  # radius of a disc whose limb is straight over the sun's
_AWAY = 1e9  # finite distance that stands for an occluder behind the sun


def sun_visibility(scene: Scene, points) -> np.ndarray:
    """Return the fraction of sun 0's light that passes all occluders and rings, without air and without the planet.

    Parameters
    ----------
    scene : Scene
        The first of its suns, its occluders and its rings count.
    points : (N, 3) or (3,) float
        [m], planet-centered.

    Returns
    -------
    (N,) ndarray
        In [0, 1]; 0 inside an occluder.

    Raises
    ------
    ParameterError
        If the points are not finite or not (N, 3).
    """
    try:
        checked = Rays.validated(points, np.ones(np.shape(points))).origins
    except ParameterError as error:
        raise ParameterError("points", error.value, error.allowed) from None
    return visibility(checked, scene.suns[0], scene)


def visibility(points, sun: Sun, scene: Scene) -> np.ndarray:
    """Return the fraction (N,) of a sun's light that passes a scene's occluders and rings, at `points` (N, 3) [m].

    A ring dims the part of the sun that the occluders leave. Of several rings each takes its share of what the
    occluders leave as if the others were not there, which is exact where no two edges lie before the sun at once.
    """
    points = np.asarray(points, dtype=np.float64)
    free = joint_visibility(points, sun, scene.occluders)
    result = free.copy()
    for ring in scene.rings:
        share = ring_visibility(points, sun, ring)
        chords = ring_chords(points, sun, ring)
        cut = (np.abs(chords.inner) < 1.0) | (np.abs(chords.outer) < 1.0)
        both = np.flatnonzero(cut & (free > 0.0) & (free < 1.0))
        if both.size:
            band = _free_band(points[both], sun, scene.occluders, chords, both)
            share[both] = 1.0 - (1.0 - chords.transmission[both]) * band / free[both]
        result *= np.clip(share, 0.0, 1.0)
    return result


def _free_band(points, sun, occluders, chords, index):
    """Return the light (N,) between the chords that no occluder hides; `index` are the points' places in `chords`."""
    sky = [_sky(points, sun, occluder) for occluder in occluders]
    k, delta, toward = (np.stack(part, axis=1) for part in zip(*sky, strict=True))
    toward = np.concatenate([toward, chords.rise[index][:, None]], axis=1)
    angle = _position_angles(points, sun, toward)
    k = np.column_stack([k, np.full(len(points), _HALF_PLANE)])
    light = []
    for edge in (chords.outer, chords.inner):
        # Light on the ring's side of an edge, hidden by a disc so large that its limb is the chord.
        beyond = np.column_stack([delta, _HALF_PLANE + np.clip(edge[index], -1.0, 1.0)])
        light.append(_in_chunks(k, beyond, angle, sun.limb_darkening))
    return light[0] - light[1]


def visible_fraction(points, sun: Sun, occluder: Occluder) -> np.ndarray:
    """Return the fraction (N,) of a sun's light that passes one occluder, at `points` (N, 3) [m].

    0 inside the occluder and in its umbra; 1 where it stands behind the sun or away from it.
    """
    k, delta, _ = _sky(np.asarray(points, dtype=np.float64), sun, occluder)
    return disc_visibility(k, delta, sun.limb_darkening)


def joint_visibility(points, sun: Sun, occluders) -> np.ndarray:
    """Return the fraction (N,) of a sun's light that passes all `occluders`, at `points` (N, 3) [m]."""
    points = np.asarray(points, dtype=np.float64)
    if not occluders:
        return np.ones(len(points))
    sky = [_sky(points, sun, occluder) for occluder in occluders]
    k, delta, toward = (np.stack(part, axis=1) for part in zip(*sky, strict=True))
    each = disc_visibility(k, delta, sun.limb_darkening)
    result = each.min(axis=1)
    several = np.flatnonzero(((each < 1.0).sum(axis=1) > 1) & (result > 0.0))
    if several.size:
        angle = _position_angles(points[several], sun, toward[several])
        result[several] = _in_chunks(k[several], delta[several], angle, sun.limb_darkening)
    return result


def discs_before_sun(points, sun: Sun, occluders, up) -> np.ndarray:
    """Return the occluders' discs (N, M, 3) as seen from `points` (N, 3) [m], in units of the sun's radius.

    Columns: the center's place along `up` (N, 3), projected across the line to the sun, and to the left or right of it,
    always the same one; the radius.
    """
    sky = [_sky(points, sun, occluder) for occluder in occluders]
    k, delta, toward = (np.stack(part, axis=1) for part in zip(*sky, strict=True))
    angle = _position_angles(points, sun, np.concatenate([toward, np.asarray(up)[:, None]], axis=1))
    aside, delta = angle[:, :-1] - angle[:, -1:], np.minimum(delta, _AWAY)
    return np.stack([delta * np.cos(aside), delta * np.sin(aside), k], axis=2)


def joint_discs(discs, u: float) -> np.ndarray:
    """Return the fraction (N,) of a unit disc's light that `discs` (N, M, 3) leave together.

    Parameters
    ----------
    discs : (N, M, 3) float
        Centers and radii in units of the sun's radius, the sun's center at the origin.
    u : float
        Limb-darkening coefficient.
    """
    x, y, k = np.moveaxis(np.asarray(discs, dtype=np.float64), 2, 0)
    delta, angle = np.hypot(x, y), np.arctan2(y, x)
    return _in_chunks(k, delta, angle, u)


def disc_visibility(k, delta, u, nodes: int = ARC_NODES) -> np.ndarray:
    """Return the fraction of a unit disc's light that a disc of radius `k` at the distance `delta` leaves.

    Parameters
    ----------
    k, delta : (...) float
        In units of the sun's radius; k > 0, or inf for an occluder that is all around.
    u : float
        Limb-darkening coefficient.
    nodes : int
        Gauss-Legendre nodes along the arc of the occluder.
    """
    k, delta = np.broadcast_arrays(np.asarray(k, dtype=np.float64), np.asarray(delta, dtype=np.float64))
    result = np.ones(k.shape)
    covered = delta + 1.0 <= k
    result[covered] = 0.0
    partly = (delta < 1.0 + k) & ~covered
    size, shift = k[partly], delta[partly]
    values = np.empty(size.size)
    for begin in range(0, size.size, _CHUNK):
        part = slice(begin, begin + _CHUNK)
        values[part] = _arc_visibility(size[part], shift[part], u, nodes)
    result[partly] = values
    return result


def _sky(points, sun, occluder):
    """Return k, delta (N,) and the vectors (N, 3) from `points` to the occluder."""
    to_sun = sun.distance * np.array(sun.direction) - points
    to_body = np.array(occluder.center) - points
    far, near = np.linalg.norm(to_sun, axis=1), np.linalg.norm(to_body, axis=1)
    sun_angle = np.arcsin(np.minimum(sun.radius / far, 1.0))
    inside = near <= occluder.radius
    body_angle = np.arcsin(np.minimum(occluder.radius / np.where(inside, occluder.radius, near), 1.0))
    across = np.linalg.norm(np.cross(to_sun, to_body), axis=1)
    angle = np.arctan2(across, np.einsum("ij,ij->i", to_sun, to_body))
    k = np.where(inside, np.inf, body_angle / sun_angle)
    delta = np.where(inside, 0.0, np.where(near >= far, np.inf, angle / sun_angle))
    return np.where(np.isinf(delta), 1.0, k), delta, to_body


def _arc_visibility(k, delta, u, nodes):
    """The fraction where the limbs cross, or the occluder is wholly in front of the sun; 1-D arrays."""
    outside = (delta + k - 1.0) * (delta + k + 1.0)
    within = (1.0 - delta + k) * (1.0 + delta - k)
    whole = outside <= 0.0
    safe = np.where(whole, 1.0, outside)
    # Half angle of the occluder's arc inside the sun, from its side that faces the sun's center.
    half = np.where(whole, np.pi, 2.0 * np.arctan(np.sqrt(np.maximum(within, 0.0) / safe)))
    # Half angle of the sun's limb behind the occluder.
    limb = np.maximum((k - 1.0 + delta) * (k + 1.0 - delta), 0.0)
    rest = np.maximum((1.0 + delta - k) * (1.0 + delta + k), np.finfo(float).tiny)
    hidden = np.where(whole, 0.0, 2.0 * np.arctan(np.sqrt(limb / rest)))

    points, weights = unit_gauss(nodes)
    stretch = np.sin(0.5 * np.pi * points)  # gathers nodes at the arc's end, at the 3/2 power
    weights = weights * 0.5 * np.pi * np.cos(0.5 * np.pi * points)
    sine = np.sin(0.5 * half[:, None] * stretch) ** 2
    k, delta = k[:, None], delta[:, None]
    r2 = (delta - k) ** 2 + 4.0 * delta * k * sine
    integrand = _circulation(r2, u) * k * ((k - delta) + 2.0 * delta * sine)
    arc = 2.0 * half * (integrand @ weights)
    covered = arc + 2.0 * hidden * (0.5 * (1.0 - u) + u / 3.0)
    return np.clip(1.0 - covered / (np.pi * (1.0 - u / 3.0)), 0.0, 1.0)


def _circulation(r2, u):
    """Return F(r)/r of the azimuthal field F whose curl is the intensity, from r^2."""
    x = np.clip(r2, 0.0, 1.0)
    root = np.sqrt(1.0 - x)
    # (1 - root^3)/(3 x) with 1 - root = x/(1 + root), so that x = 0 is regular.
    return 0.5 * (1.0 - u) + u * (1.0 + root + root * root) / (3.0 * (1.0 + root))


def _position_angles(points, sun, toward):
    """Return the angles (N, M) of the occluders around the sun's center in the sky."""
    axis = sun.distance * np.array(sun.direction) - points
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    helper = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    east = np.cross(axis, helper)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    north = np.cross(axis, east)
    return np.arctan2(np.einsum("nmi,ni->nm", toward, north), np.einsum("nmi,ni->nm", toward, east))


def _in_chunks(k, delta, angle, u):
    """Return `_ring_visibility` of arrays (N, M) of any length."""
    parts = [_ring_visibility(*(a[i : i + _CHUNK] for a in (k, delta, angle)), u) for i in range(0, len(k), _CHUNK)]
    return np.concatenate(parts)


def _ring_visibility(k, delta, angle, u):
    """Integrate the light outside the union of M discs over rings of the sun's disc; arrays (N, M)."""
    delta = np.minimum(delta, _AWAY)
    kinks = np.concatenate([np.abs(k - delta), k + delta, _mutual_radii(k, delta, angle)], axis=1)
    edges = np.sort(np.pad(np.minimum(kinks, 1.0), ((0, 0), (1, 1)), constant_values=(0.0, 1.0)), axis=1)
    points, weights = unit_gauss(RING_NODES)
    clustered = np.sin(0.5 * np.pi * points) ** 2  # square roots at both ends of a piece
    weights = weights * np.pi * np.sin(0.5 * np.pi * points) * np.cos(0.5 * np.pi * points)
    width = np.diff(edges, axis=1)
    r = (edges[:, :-1, None] + width[:, :, None] * clustered).reshape(len(k), -1)
    weight = (width[:, :, None] * weights).reshape(len(k), -1)

    cosine = (r[:, None] ** 2 + ((delta - k) * (delta + k))[:, :, None]) / (
        2.0 * np.maximum(r[:, None] * delta[:, :, None], 1e-200)
    )
    half = np.arccos(np.clip(cosine, -1.0, 1.0))
    intensity = 1.0 - u * (1.0 - np.sqrt((1.0 - r) * (1.0 + r)))
    free = 2.0 * np.pi - _union(angle[:, :, None] - half, angle[:, :, None] + half)
    return np.clip((weight * r * intensity * free).sum(axis=1) / (np.pi * (1.0 - u / 3.0)), 0.0, 1.0)


def _mutual_radii(k, delta, angle):
    """Return how far from the sun's center (N, M (M - 1)) two occluders' limbs cross."""
    x, y = delta * np.cos(angle), delta * np.sin(angle)
    radii = []
    for i in range(k.shape[1]):
        for j in range(i):
            dx, dy = x[:, j] - x[:, i], y[:, j] - y[:, i]
            apart = np.maximum(np.hypot(dx, dy), 1e-12)  # concentric limbs do not cross
            along = (apart + (k[:, i] - k[:, j]) / apart * (k[:, i] + k[:, j])) / 2.0
            across = np.sqrt(np.maximum((k[:, i] - along) * (k[:, i] + along), 0.0))
            ux, uy = dx / apart, dy / apart
            for side in (-across, across):
                radius = np.hypot(x[:, i] + along * ux - side * uy, y[:, i] + along * uy + side * ux)
                radii.append(np.where(np.isfinite(radius), radius, 1.0))
    return np.stack(radii, axis=1)


def _union(first, last):
    """Return the length of the union of M arcs [first, last] (N, M, Q), each at most a full turn."""
    start = np.mod(first, 2.0 * np.pi)
    stop = start + (last - first)
    # An arc that passes the full turn goes on from 0.
    start = np.concatenate([start, np.zeros_like(start)], axis=1)
    stop = np.concatenate([np.minimum(stop, 2.0 * np.pi), np.maximum(stop - 2.0 * np.pi, 0.0)], axis=1)
    order = np.argsort(start, axis=1)
    start, stop = np.take_along_axis(start, order, axis=1), np.take_along_axis(stop, order, axis=1)
    reached = np.maximum.accumulate(stop, axis=1)
    before = np.concatenate([np.zeros_like(stop[:, :1]), reached[:, :-1]], axis=1)
    return np.maximum(stop - np.maximum(start, before), 0.0).sum(axis=1)
