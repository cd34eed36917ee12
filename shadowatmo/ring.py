"""Rings around a planet or a moon: flat annuli that dim the sun by their optical depth.

The line from a point to the sun's center crosses the ring's plane at some radius. Over the sun's disc that radius
changes as along a straight line, so that an edge of the ring cuts the limb-darkened disc along a chord; the light
beyond a chord has a closed form. The edge is taken for straight over the sun's disc, whose image on the ring is a
thousand times smaller than the ring itself for Saturn.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.parameters import MAX_LENGTH
from shadowatmo.validation import number, unit_vector, vector

EDGE_ON = 1e-6  # sine of the sun's height over the ring's plane below which a ring has no shadow


@dataclass(frozen=True)
class Ring:
    """A thin, flat ring that lets part of the sunlight through.

    Parameters
    ----------
    center : (3,) float
        Planet-centered [m]; the origin for a ring of the planet itself.
    normal : (3,) float
        Across its plane, either way; normalized here.
    inner_radius, outer_radius : float
        Of its edges [m], 0 <= inner < outer.
    optical_depth : float
        Along the normal, >= 0. Light that comes in under an angle of cosine c passes with exp(-optical_depth / |c|).
    """

    center: tuple[float, float, float]
    normal: tuple[float, float, float]
    inner_radius: float
    outer_radius: float
    optical_depth: float

    def __post_init__(self):
        inner = number("inner_radius", self.inner_radius, low=0, high=MAX_LENGTH)
        checked = {
            "center": vector("center", self.center, low=-1e20, high=1e20),
            "normal": unit_vector("normal", self.normal),
            "inner_radius": inner,
            "outer_radius": number("outer_radius", self.outer_radius, low=0, open_low=True, high=MAX_LENGTH),
            "optical_depth": number("optical_depth", self.optical_depth, low=0),
        }
        if checked["outer_radius"] <= inner:
            raise ParameterError("outer_radius", self.outer_radius, f"more than inner_radius = {inner:g}")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def transmission(self, sun) -> float:
        """Return the share of a sun's light that passes where the ring is, for parallel light."""
        return math.exp(-self.optical_depth / max(abs(np.dot(self.normal, sun.direction)), EDGE_ON))


def light_beyond_chord(s, u) -> np.ndarray:
    """Return the share of a unit disc's light beyond the chord at `s` from its center; u = limb darkening."""
    s = np.clip(s, -1.0, 1.0)
    even = np.arccos(s) - s * np.sqrt((1.0 - s) * (1.0 + s))
    dome = 0.5 * math.pi * (2.0 / 3.0 - s + s**3 / 3.0)
    return ((1.0 - u) * even + u * dome) / (math.pi * (1.0 - u / 3.0))


@dataclass(frozen=True, eq=False)
class Chords:
    """Where the edges of a ring cut the sun's disc, as seen from N points.

    Parameters
    ----------
    inner, outer : (N,) float
        Distances of the edges from the sun's center, in its radii, along `rise`; both 2 where the ring is elsewhere.
    rise : (N, 3) float
        Across the line to the sun: toward larger radii of the ring.
    transmission : (N,) float
        Share of the light that passes between the edges.
    """

    inner: np.ndarray
    outer: np.ndarray
    rise: np.ndarray
    transmission: np.ndarray


def ring_visibility(points, sun, ring) -> np.ndarray:
    """Return the fraction (N,) of a sun's light that a ring lets through to `points` (N, 3) [m]."""
    chords = ring_chords(points, sun, ring)
    covered = light_beyond_chord(chords.inner, sun.limb_darkening)
    covered -= light_beyond_chord(chords.outer, sun.limb_darkening)
    return 1.0 - covered * (1.0 - chords.transmission)


def ring_chords(points, sun, ring) -> Chords:
    """Return how a ring's edges cut the sun's disc as seen from `points` (N, 3) [m]."""
    points, normal, center = np.asarray(points, dtype=np.float64), np.array(ring.normal), np.array(ring.center)
    to_sun = sun.distance * np.array(sun.direction) - points
    far = np.linalg.norm(to_sun, axis=1)
    to_sun /= far[:, None]
    slant = to_sun @ normal
    slant = np.where(np.abs(slant) < EDGE_ON, EDGE_ON, slant)
    path = (center - points) @ normal / slant
    offset = points + path[:, None] * to_sun - center
    radius = np.maximum(np.linalg.norm(offset, axis=1), 1e-9)
    outward = offset / radius[:, None]
    rise = outward - normal * (np.einsum("ij,ij->i", outward, to_sun) / slant)[:, None]
    blur = np.maximum(path * np.arcsin(sun.radius / far) * np.linalg.norm(rise, axis=1), 1e-9)
    between = (path > 0.0) & (path < far)
    inner, outer = (np.where(between, (edge - radius) / blur, 2.0) for edge in (ring.inner_radius, ring.outer_radius))
    return Chords(inner, outer, rise, np.exp(-ring.optical_depth / np.abs(slant)))


def dims_the_air(atmosphere, sun, ring) -> bool:
    """Whether a ring's shadow may meet the sphere of the air."""
    normal, direction = np.array(ring.normal), np.array(sun.direction)
    slant = normal @ direction
    if abs(slant) < EDGE_ON or ring.optical_depth == 0.0:
        return False
    center, reach = np.array(ring.center), 1.01 * atmosphere.top_radius
    path = center @ normal / slant
    spread = reach / abs(slant)
    spread_and_blur = spread + (abs(path) + spread) * sun.radius / sun.distance / abs(slant)
    radius = np.linalg.norm(path * direction - center)
    nearest, farthest = radius - spread_and_blur, radius + spread_and_blur
    return bool(path + spread > 0.0 and nearest < ring.outer_radius and farthest > ring.inner_radius)


def chord_polynomial(u) -> np.ndarray:
    """Return a (4,) of 1/2 - s (a0 + a1 s^2 + a2 s^4 + a3 s^6), `light_beyond_chord` within 1e-3, exact at +-1."""
    s = np.cos(np.linspace(0.0, 0.5 * np.pi, 200, endpoint=False))
    powers = s[:, None] ** np.array([2, 4, 6]) - 1.0
    rest = (0.5 - light_beyond_chord(s, u)) / s - 0.5
    high = np.linalg.lstsq(powers * s[:, None], rest * s, rcond=None)[0]
    return np.array([0.5 - high.sum(), *high])
