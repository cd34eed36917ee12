"""Float64 twin of shaders/terminator_moons.glsl: moons before a sun whose disc the planet's limb hides in part.

Strip by strip of the disc above the horizon (terminator.py) a moon hides an interval of the chord, and several moons
the union of theirs. What passes is the light of the uniform disc above the horizon times the share of the limb-darkened
light there, dimmed by the air strip by strip, that no moon hides:

    integral of T w s / integral of T w over the strips above the horizon,

w = light of a strip, s = the part of it that is free, T = transmittance. Without a moon that is 1; where T is the same
for all of the disc, it is the visible fraction. Lengths are in radii of the sun, the strip at the height y = cos b.
"""

import numpy as np

from shadowatmo.eclipse import discs_before_sun, joint_visibility, visibility
from shadowatmo.quadrature import gauss_legendre

PIECE_NODES = 16  # strips of each piece between kinks
_CHUNK = 256


def chord_light(x, half_chord, u):
    """Return the light from the middle of a chord to `x`; u = limb darkening."""
    rest = np.sqrt(np.maximum((half_chord - x) * (half_chord + x), 0.0))
    return (1.0 - u) * x + 0.5 * u * (x * rest + half_chord * half_chord * np.arctan2(x, rest))


def free_light(discs, y, u):
    """Return the light (N, Q) of the strips at heights `y` (N, Q) that no disc hides, and the light of all of each.

    `discs` are (N, M, 3): height, place across, and radius.
    """
    half_chord = np.sqrt(np.maximum((1.0 - y) * (1.0 + y), 0.0))[:, None]
    up, across, k = (part[..., None] for part in np.moveaxis(discs, 2, 0))
    offset = y[:, None] - up
    half = np.sqrt(np.maximum((k - offset) * (k + offset), 0.0))
    start, stop = (
        chord_light(np.clip(across + side, -half_chord, half_chord), half_chord, u) for side in (-half, half)
    )
    order = np.argsort(start, axis=1)
    start, stop = np.take_along_axis(start, order, axis=1), np.take_along_axis(stop, order, axis=1)
    reached = np.maximum.accumulate(stop, axis=1)
    before = np.concatenate([start[:, :1], reached[:, :-1]], axis=1)
    hidden = np.maximum(stop - np.maximum(start, before), 0.0).sum(axis=1)
    whole = 2.0 * chord_light(half_chord, half_chord, u)[:, 0]
    return whole - hidden, whole


def kinks(discs) -> np.ndarray:
    """Return the heights (N, 2 + 4 M + M (M - 1)) of strips between which the free light is smooth."""
    sun = np.zeros((len(discs), 1, 3))
    sun[..., 2] = 1.0
    every = np.concatenate([sun, discs], axis=1)
    up, across, k = np.moveaxis(every, 2, 0)
    found = [up - k, up + k]
    for i in range(every.shape[1]):
        for j in range(i):
            dx, dy = across[:, i] - across[:, j], up[:, i] - up[:, j]
            apart = np.maximum(np.hypot(dx, dy), 1e-12)  # concentric limbs do not cross
            along = (apart + (k[:, j] - k[:, i]) / apart * (k[:, j] + k[:, i])) / 2.0
            aside = np.sqrt(np.maximum((k[:, j] - along) * (k[:, j] + along), 0.0))
            found += [(up[:, j] + (along * dy + side * dx) / apart)[:, None] for side in (-aside, aside)]
    return np.concatenate(found, axis=1)


def strip_weights(discs, u, last, count):
    """Return weights (N, count) by which strips add up to the free light, and the same for all light.

    The strips are those at b = last x, x the nodes of the Gauss rule of `count`; the light dims slowly from strip to
    strip and is interpolated between them, while what the moons leave is integrated from kink to kink.
    """
    b = np.arccos(np.clip(kinks(discs), -1.0, 1.0))
    edges = np.sort(np.minimum(np.column_stack([b, last]), last[:, None]), axis=1)
    points, weights = gauss_legendre(PIECE_NODES)
    clustered = np.sin(0.5 * np.pi * points) ** 2  # square roots at both ends of a piece
    weights = weights * np.pi * np.sin(0.5 * np.pi * points) * np.cos(0.5 * np.pi * points)
    width = np.diff(edges, axis=1)[:, :, None]
    b = (edges[:, :-1, None] + width * clustered).reshape(len(last), -1)
    measure = (width * weights).reshape(len(last), -1) * np.sin(b)
    nodes, node_weights = gauss_legendre(count)
    basis = np.polynomial.legendre.legvander(2.0 * b / last[:, None] - 1.0, count - 1)
    at_nodes = np.polynomial.legendre.legvander(2.0 * nodes - 1.0, count - 1)
    to_nodes = (2 * np.arange(count) + 1)[:, None] * at_nodes.T * node_weights
    return [np.einsum("nq,nqm->nm", measure * light, basis) @ to_nodes for light in free_light(discs, np.cos(b), u)]


def share_above_limb(points, sun, occluders, last, light):
    """Return the share (N, 3) of the light of the disc above the horizon that passes the occluders.

    Parameters
    ----------
    points : (N, 3) float
        [m], planet-centered.
    last : (N,) float
        b of the horizon, > 0.
    light : (N, K, 3) float
        Of the strips at b = last x, x the nodes of the Gauss rule of K; per light that they send.
    """
    result = np.ones((len(points), 3))
    for begin in range(0, len(points), _CHUNK):
        part = slice(begin, begin + _CHUNK)
        discs = discs_before_sun(points[part], sun, occluders, up=points[part])
        free, whole = strip_weights(discs, sun.limb_darkening, last[part], light.shape[1])
        passing, every = (np.einsum("nk,nkc->nc", weight, light[part]) for weight in (free, whole))
        result[part] = passing / np.where(every > 0.0, every, 1.0)
    return np.clip(result, 0.0, 1.0)


def visibility_above_limb(points, sun, scene, last, light):
    """Return what moons and rings leave (N, 3) of the disc above the horizon; parameters as in `share_above_limb`.

    A ring dims it as it does the whole disc.
    """
    free, visible = joint_visibility(points, sun, scene.occluders), visibility(points, sun, scene)
    result = np.repeat(visible[:, None], 3, axis=1)
    part = np.flatnonzero((free > 0.0) & (free < 1.0) & (last > 0.0))
    if part.size:
        share = share_above_limb(points[part], sun, scene.occluders, last[part], light[part])
        result[part] = share * (visible / np.where(free > 0.0, free, 1.0))[part, None]
    return result
