"""Where a ray is in the air, and where in a shadow, as intervals along it.

A ray is first cut to its segment in the air and re-anchored: at its origin if that lies inside the air, else
where it enters. Everything else is measured from the anchor, s = t - t_in. From 1e11 m away the coordinates
of the origin still fix the segment to a fraction of a millimeter, provided that the impact vector comes from
a cross product and the products are summed with their rounding errors (Ogita, Rump and Oishi 2005, algorithm
Dot2). Roots come from the form of the quadratic formula that does not cancel, discriminants as a difference
of two lengths times their sum.

Intervals are pairs (s0, s1) of (N,) arrays with 0 <= s0 <= s1 <= length, free of nan; an empty one has s0 =
s1.

A sphere of radius R and a sun of radius Rs at the distance D have an umbra cone of half-angle phi, sin phi =
(Rs - R)/D, and an outer cone, sin psi = (Rs + R)/D. With w = x - center, z along the axis away from the sun
and rho across it, x is within the double cone where rho cos phi <= |R - z sin phi|: the nappe R - z sin phi
>= 0 is the umbra, the other one the antumbra, both beyond the plane of the tangent circle z = R sin phi. The
outer cone is the same with -sin psi for sin phi; so is an umbra that widens because R > Rs.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from shadowatmo.medium import altitude_from_power
from shadowatmo.parameters import Atmosphere, Sun
from shadowatmo.rays import Rays

_SPLITTER = 134217729.0  # 2^27 + 1, halves a float64 significand (Dekker 1971)
Interval = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Segments:
    """The parts of N rays inside the air.

    Parameters
    ----------
    t_in, t_out, t_end, end : (N,)
        As in `ProbeResult`: nan and "miss" where the ray misses the air.
    anchor : (N, 3) float
        The point at t_in [m].
    direction : (N, 3) float
        Unit vector.
    length : (N,) float
        t_end - t_in [m], without the rounding of t; 0 on a miss.
    power : (N,) float
        |anchor|^2 - Rb^2, Rb the radius of the ground [m^2].
    slope : (N,) float
        dot(anchor, direction) [m].
    """

    t_in: np.ndarray
    t_out: np.ndarray
    t_end: np.ndarray
    end: np.ndarray
    anchor: np.ndarray
    direction: np.ndarray
    length: np.ndarray
    power: np.ndarray
    slope: np.ndarray

    def __len__(self) -> int:
        return len(self.length)

    def points(self, s, index=slice(None)) -> np.ndarray:
        """Return the points (N, ..., 3) at the distances `s` (N, ...) from the anchors of rays `index`."""
        extra = (slice(None), *(None,) * (np.ndim(s) - 1))
        return self.anchor[index][extra] + s[..., None] * self.direction[index][extra]

    def altitude(self, s, radius: float, index=slice(None)) -> np.ndarray:
        """Return the altitudes (N, ...) [m] over the ground of `radius` at the distances `s` (N, ...)."""
        return altitude_from_power(radius, self.power_at(s, index))

    def power_at(self, s, index=slice(None)) -> np.ndarray:
        """Return |x|^2 - Rb^2 (N, ...) at the distances `s` (N, ...) from the anchors of rays `index`."""
        extra = (slice(None), *(None,) * (np.ndim(s) - 1))
        return self.power[index][extra] + s * (s + 2.0 * self.slope[index][extra])


class Cones(NamedTuple):
    """Intervals inside the shadow cones of a sphere; umbra and antumbra are part of `outer`."""

    umbra: Interval
    antumbra: Interval
    outer: Interval


def trace(atmosphere: Atmosphere, rays: Rays) -> Segments:
    """Return the segments of `rays` in the air.

    An origin on or below the ground ends at once, at length 0, where the ray looks down, and starts there
    where the ray looks up.
    """
    bottom, top = atmosphere.bottom_radius, atmosphere.top_radius
    origin, direction = rays.origins, rays.directions
    slope = _dot(origin, direction)
    cross = _cross(origin, direction)
    power, chord = _sphere(origin, slope, cross, bottom)
    top_power, top_chord = _sphere(origin, slope, cross, top)
    half_out, half_ground = np.sqrt(np.maximum(top_chord, 0.0)), np.sqrt(np.maximum(chord, 0.0))

    inside = top_power <= 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        entry = np.where(inside, 0.0, top_power / (half_out - slope))
        t_out = np.where(slope <= 0.0, half_out - slope, -top_power / (half_out + slope))
        ground = np.where(power > 0.0, power / (half_ground - slope), 0.0)
    hit = (top_chord > 0.0) & np.where(inside, t_out > 0.0, slope < 0.0)
    ground = np.where((slope < 0.0) & ((chord >= 0.0) | (power <= 0.0)), ground, np.inf)

    # Lengths from the anchor: differences of chords where t itself is too coarse.
    shell = (top - bottom) * (top + bottom)
    with np.errstate(invalid="ignore", divide="ignore"):
        to_top = np.where(inside, t_out, 2.0 * half_out)
        to_ground = np.where(
            inside, ground, np.where(np.isinf(ground), np.inf, shell / (half_out + half_ground))
        )
    to_limit = np.where(inside, rays.t_max, np.maximum(rays.t_max + slope + half_out, 0.0))
    length = np.minimum(np.minimum(to_top, to_ground), to_limit)
    end = np.where(length == to_limit, "t_max", "top")
    end = np.where((length == to_ground) & ((to_limit > 0.0) | inside), "ground", end)
    end = np.where(hit, end, "miss")

    t_end = entry + length
    t_end = np.where(end == "ground", ground, np.where(end == "top", t_out, t_end))
    t_end = np.where((end == "t_max") & (length > 0.0), rays.t_max, t_end)
    outside = (hit & ~inside)[:, None]
    return Segments(
        t_in=np.where(hit, entry, np.nan),
        t_out=np.where(hit, t_out, np.nan),
        t_end=np.where(hit, t_end, np.nan),
        end=end,
        anchor=np.where(outside, np.cross(direction, cross) - half_out[:, None] * direction, origin),
        direction=direction,
        length=np.where(hit, length, 0.0),
        power=np.where(outside[:, 0], shell, power),
        slope=np.where(outside[:, 0], -half_out, slope),
    )


def sphere_crossings(
    segments: Segments, bottom_radius: float, altitude: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the two distances (N,) at which the lines cross `altitude` [m], clipped to the segments.

    A line that does not reach it gives its tangent point twice.
    """
    power = altitude * (2.0 * bottom_radius + altitude) - segments.power
    half = np.sqrt(np.maximum(segments.slope**2 + power, 0.0))
    first, second = -segments.slope - half, -segments.slope + half
    return np.clip(first, 0.0, segments.length), np.clip(second, 0.0, segments.length)


def planet_shadow(segments: Segments, bottom_radius: float, sun_direction) -> Interval:
    """Return the interval in the planet's parallel-sun shadow: behind it, within its radius of the axis."""
    sun = np.asarray(sun_direction)
    start, step = np.cross(segments.anchor, sun), np.cross(segments.direction, sun)
    radius = np.linalg.norm(start, axis=1)
    a, b = np.einsum("ij,ij->i", step, step), np.einsum("ij,ij->i", start, step)
    c = (radius - bottom_radius) * (radius + bottom_radius)
    miss = np.abs(
        np.cross(segments.anchor, segments.direction) @ sun
    )  # |step| times the distance of line and axis
    reach = bottom_radius * np.sqrt(a)
    disc = np.where(c < 0.0, b * b - a * c, (reach - miss) * (reach + miss))
    low, high = _roots(a, b, c, disc)
    crosses = disc > 0.0
    low = np.where(crosses, low, np.where((a == 0.0) & (c < 0.0), -np.inf, np.inf))
    high = np.where(crosses, high, np.inf)
    behind = _half_line(-(segments.anchor @ sun), -(segments.direction @ sun))
    return _clip(segments.length, (low, high), behind)


def cones(segments: Segments, center, radius: float, sun: Sun) -> Cones:
    """Return the intervals in umbra, antumbra and outer cone of a sphere in the light of a finite sun.

    Parameters
    ----------
    segments : Segments
        N rays.
    center : (3,) float
        Center of the sphere [m]; the origin for the planet itself.
    radius : float
        Its radius [m].
    sun : Sun
        Its center is at distance * direction. A sphere that touches the sun casts no shadow here.
    """
    center = np.asarray(center, dtype=np.float64)
    axis = center - sun.distance * np.array(sun.direction)
    distance = np.linalg.norm(axis)
    if distance <= sun.radius + radius:
        nothing = (np.zeros(len(segments)), np.zeros(len(segments)))
        return Cones(nothing, nothing, nothing)
    axis = axis / distance
    sine = (sun.radius - radius) / distance
    return Cones(
        umbra=_cone(segments, center, axis, radius, sine, far=False),
        antumbra=_cone(segments, center, axis, radius, sine, far=True),
        outer=_cone(segments, center, axis, radius, -(sun.radius + radius) / distance, far=False),
    )


def disc_cones(segments: Segments, bottom_radius: float, sun: Sun) -> tuple[Interval, Interval]:
    """Return the intervals in which the planet hides all / any of the disc of a sun infinitely far away."""
    axis, sine = -np.array(sun.direction), sun.radius / sun.distance
    nappe = [_cone(segments, np.zeros(3), axis, bottom_radius, s, far=False) for s in (sine, -sine)]
    return nappe[0], nappe[1]


def _cone(segments, center, axis, radius, sine, far) -> Interval:
    """Return the interval in one nappe of a double cone, beyond the plane of its tangent circle.

    `sine` is sin phi of the module's docstring, `far` asks for the nappe beyond the apex.
    """
    w = segments.anchor - center
    z0, z1 = w @ axis, segments.direction @ axis
    start, step = np.cross(w, axis), np.cross(segments.direction, axis)
    e0, e1 = radius - sine * z0, -sine * z1  # R - z sin phi along the ray
    cos = np.sqrt((1.0 - sine) * (1.0 + sine))
    rho, slant = np.linalg.norm(start, axis=1), np.linalg.norm(step, axis=1)
    a = (e1 - cos * slant) * (
        e1 + cos * slant
    ) + 0.0  # no negative zero: its sign would pick the root at infinity
    b = e0 * e1 - cos * cos * np.einsum("ij,ij->i", start, step)
    c = (e0 - cos * rho) * (e0 + cos * rho)
    wide = np.linalg.norm(e0[:, None] * step - e1[:, None] * start, axis=1)
    narrow = cos * np.abs(np.cross(w, segments.direction) @ axis)
    disc = np.where(a * c < 0.0, b * b - a * c, cos * cos * (wide - narrow) * (wide + narrow))

    low, high = _roots(a, b, c, disc)
    real = disc >= 0.0
    upward = (e1 > 0.0) != far  # the wanted nappe lies toward larger s, where the line runs through both
    first = np.where(a < 0.0, np.where(real, low, np.inf), np.where(upward, high, -np.inf))
    last = np.where(a < 0.0, high, np.where(upward, np.inf, low))
    flat = (a == 0.0) & (b == 0.0)  # along the surface's own lines, in a cylinder
    first = np.where(flat, np.where(c >= 0.0, -np.inf, np.inf), first)
    last = np.where(flat, np.inf, last)
    sign = -1.0 if far else 1.0
    nappe = _half_line(sign * e0, sign * e1)
    beyond = _half_line(z0 - radius * sine, z1)
    return _clip(segments.length, (first, last), nappe, beyond)


def _roots(a, b, c, disc):
    """Return the sorted roots of a s^2 + 2 b s + c, given b^2 - a c; one is infinite where a = 0."""
    q = -(b + np.where(b < 0.0, -1.0, 1.0) * np.sqrt(np.maximum(disc, 0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = q / a, c / q
    one = np.where(np.isnan(one), 0.0, one)
    two = np.where(np.isnan(two), one, two)
    return np.minimum(one, two), np.maximum(one, two)


def _half_line(c0, c1) -> Interval:
    """Return where c0 + c1 s >= 0, as (low, high) with infinite ends; low = inf where nowhere."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = -c0 / c1
    low = np.where(c1 > 0.0, root, np.where((c1 < 0.0) | (c0 >= 0.0), -np.inf, np.inf))
    return low, np.where(c1 < 0.0, root, np.inf)


def _clip(length, *intervals) -> Interval:
    """Return the intersection of the intervals with [0, length]."""
    low, high = np.zeros_like(length), length
    for first, last in intervals:
        low, high = np.maximum(low, first), np.minimum(high, last)
    low = np.minimum(low, length)
    return low, np.maximum(low, high)


def _sphere(origin, slope, cross, radius):
    """Return |o|^2 - radius^2 and radius^2 - (distance of line and center)^2, each by its stable form."""
    column = np.full((len(origin), 1), radius)
    power = _dot(np.hstack([origin, column]), np.hstack([origin, -column]))
    impact = np.linalg.norm(cross, axis=1)
    near = np.maximum(slope**2, np.abs(power)) < radius**2
    return power, np.where(near, slope**2 - power, (radius - impact) * (radius + impact))


def _dot(a, b):
    """Return the dot products of rows, as if computed with twice the digits and then rounded."""
    total, error = _two_product(a[:, 0], b[:, 0])
    for i in range(1, a.shape[1]):
        product, product_error = _two_product(a[:, i], b[:, i])
        total, sum_error = _two_sum(total, product)
        error = error + (product_error + sum_error)
    return total + error


def _cross(a, b):
    """Return the cross products of rows, their components as exact as those of `_dot`."""
    pairs = ((1, 2), (2, 0), (0, 1))
    return np.stack([_dot(a[:, [i, j]], np.stack([b[:, j], -b[:, i]], axis=1)) for i, j in pairs], axis=1)


def _two_product(a, b):
    """Return a b and its rounding error (Dekker 1971)."""
    product = a * b
    a_high = _SPLITTER * a - (_SPLITTER * a - a)
    b_high = _SPLITTER * b - (_SPLITTER * b - b)
    a_low, b_low = a - a_high, b - b_high
    return product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)


def _two_sum(a, b):
    """Return a + b and its rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)
