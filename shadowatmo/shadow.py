"""Float64 twin of shaders/shadow.glsl: shadow volumes as cones about an axis, and where a ray is inside them.

The planet's parallel-sun shadow is a cone of zero slope. The geometry of umbra, antumbra and penumbra of a sphere of
radius R in the light of a sphere of radius Rs at distance D: sin phi = (Rs - R)/D, sin psi = (Rs + R)/D.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.ray import safe_sqrt

FAR_AWAY = 1e30  # m, stands for infinity where infinity times zero would follow
UMBRA, ANTUMBRA = 1.0, -1.0  # which nappe of the cone


@dataclass(frozen=True)
class Cone:
    """rho <= radius + excess - z slope for z in [near, far] along the axis, away from the sun; [m], slope apart."""

    radius: float
    slope: float = 0.0
    excess: float = 0.0
    near: float = 0.0
    far: float = FAR_AWAY

    def width(self, z):
        """Radius [m] of the volume at z [m]; negative beyond the apex."""
        return self.radius + self.excess - z * self.slope

    def moved(self, z) -> "Cone":
        """Return the same volume with lengths along the axis counted from `z` [m]; its radius is the width there."""
        far = self.far if self.far >= FAR_AWAY else self.far - z
        return Cone(self.width(z), self.slope, 0.0, self.near - z, far)


def cylinder(radius) -> Cone:
    """Return the shadow of a sphere in parallel light."""
    return Cone(radius)


def umbra_cone(radius, sun_radius, distance) -> Cone:
    """Return the umbra of a sphere `distance` from the sun's center; it widens where the sun is the smaller one."""
    sine = (sun_radius - radius) / distance
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    apex = radius / sine if sine > 0.0 else FAR_AWAY
    return Cone(radius, sine / cosine, radius * sine * sine / (cosine * (1.0 + cosine)), radius * sine, apex)


def antumbra_cone(radius, sun_radius, distance) -> Cone:
    """Return the umbra's cone beyond its apex, to be met on the nappe ANTUMBRA."""
    umbra = umbra_cone(radius, sun_radius, distance)
    return Cone(radius, umbra.slope, umbra.excess, umbra.far, FAR_AWAY)


def penumbra_cone(radius, sun_radius, distance) -> Cone:
    """Return the outer cone, which holds penumbra, umbra and antumbra."""
    sine = (sun_radius + radius) / distance
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    return Cone(radius, -sine / cosine, radius * sine * sine / (cosine * (1.0 + cosine)), -radius * sine, FAR_AWAY)


@dataclass(frozen=True, eq=False)
class AxisRay:
    """Rays (N,) seen from a shadow axis, at their base points; fields as in the GLSL struct of this name.

    z : along the axis [m]; dz : cosine of ray and axis; across : squared sine; drift : half the derivative of
    rho^2 [m]; impact : smallest distance of ray and axis times the sine [m]; rim : rho^2 - R^2 [m^2].
    """

    z: np.ndarray
    dz: np.ndarray
    across: np.ndarray
    drift: np.ndarray
    impact: np.ndarray
    rim: np.ndarray


def axis_ray(points, directions, axis, center, radius) -> AxisRay:
    """Return the rays of base points (N, 3) [m] along unit directions (N, 3), seen from a body's shadow axis (3,)."""
    relative = points - center
    off_axis = np.cross(relative, axis)  # perpendicular to the axis, as long as the distance from it
    normal = np.cross(directions, axis)
    rho = np.linalg.norm(off_axis, axis=1)
    return AxisRay(
        z=relative @ axis,
        dz=directions @ axis,
        across=np.einsum("ij,ij->i", normal, normal),
        drift=np.einsum("ij,ij->i", off_axis, normal),
        impact=np.einsum("ij,ij->i", off_axis, np.cross(axis, normal)),
        rim=(rho - radius) * (rho + radius),
    )


def slab_interval(a, b, low, high):
    """Return the values of t, (start, end), at which a + t b lies in [low, high]."""
    safe = np.where(np.abs(b) < 1e-12, np.where(b < 0.0, -1e-12, 1e-12), b)
    t = np.stack([(low - a) / safe, (high - a) / safe])
    return np.min(t, axis=0), np.max(t, axis=0)


def cone_interval(ray, cone, nappe=UMBRA):
    """Return where the lines are inside one nappe of a cone: (start, end) in t, both (N,); empty where start >= end."""
    delta = cone.excess - ray.z * cone.slope
    w = cone.radius + delta
    dw = -ray.dz * cone.slope
    a = ray.across - dw * dw
    b = ray.drift - w * dw
    c = ray.rim - delta * (2.0 * cone.radius + delta)
    u = ray.across * w - dw * ray.drift
    parallel = ray.across < 1e-13
    safe_across = np.maximum(ray.across, 1e-30)
    near = parallel | (b * b * safe_across < u * u)
    discriminant = np.where(near, b * b - a * c, (u * u - ray.impact * ray.impact * a) / safe_across)

    slab = slab_interval(ray.z, ray.dz, cone.near, cone.far)
    root = safe_sqrt(discriminant)
    q = np.where(b >= 0.0, -(b + root), root - b)
    safe_q = np.where(np.abs(q) < 1e-30, 1e-30, q)
    safe_a = np.where(np.abs(a) < 1e-20, np.where(a < 0.0, -1e-20, 1e-20), a)
    roots = np.sort(np.clip(np.stack([q / safe_a, c / safe_q]), -FAR_AWAY, FAR_AWAY), axis=0)
    opens_ahead = nappe * dw > 0.0
    start = np.where(a > 0.0, roots[0], np.where(opens_ahead, roots[1], -FAR_AWAY))
    end = np.where(a > 0.0, roots[1], np.where(opens_ahead, FAR_AWAY, roots[0]))
    start, end = np.maximum(start, slab[0]), np.minimum(end, slab[1])
    middle = 0.5 * (np.maximum(start, -FAR_AWAY) + np.minimum(end, FAR_AWAY))
    empty = (a > 0.0) & ((discriminant <= 0.0) | (nappe * (w + middle * dw) < 0.0))
    if cone.slope == 0.0:
        start, end = np.where(parallel, slab[0], start), np.where(parallel, slab[1], end)
        empty = np.where(parallel, c >= 0.0, empty)
    return np.where(empty, FAR_AWAY, start), np.where(empty, FAR_AWAY, end)
