"""Float64 twin of shaders/ray.glsl: a view ray inside the air, carried by k = r^2 - R^2 and not by r.

t counts from the ray's base point: the camera inside the air, the entry into the shell outside. x = distance from the
tangent point, so x = ray.x + t, and k(t) = k_base + t (t + 2 x_base). See the shader for why.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Ray:
    """Rays (N,) of one atmosphere; fields as in the GLSL struct of this name.

    x : base point counted from the tangent point [m]; k, tangent_k : r^2 - R^2 of base and tangent point [m^2];
    start : camera to base point [m]; air : base point to the exit through the top [m], negative on a miss.
    """

    x: np.ndarray
    k: np.ndarray
    tangent_k: np.ndarray
    start: np.ndarray
    air: np.ndarray


def safe_sqrt(v):
    """Square root of the positive part."""
    return np.sqrt(np.maximum(v, 0.0))


def k_of(atmosphere, altitude):
    """Return r^2 - R^2 [m^2] at an altitude [m]."""
    return altitude * (2.0 * atmosphere.bottom_radius + altitude)


def altitude_of(atmosphere, k):
    """Return the altitude [m] of a point by its k [m^2]."""
    radius = atmosphere.bottom_radius
    return k / (radius + np.sqrt(np.maximum(radius * radius + k, 0.25 * radius * radius)))


def k_along(ray, t):
    """Return k [m^2] at distance t [m] from the base point."""
    return ray.k + t * (t + 2.0 * ray.x)


def far_root(x, c, root):
    """Return the root of t^2 + 2 x t + c = 0 farther along, root = sqrt(x^2 - c), without cancellation."""
    return np.where(x > 0.0, -c / np.where(x > 0.0, x + root, 1.0), root - x)


def make_ray(atmosphere, x, k, tangent_k) -> Ray:
    """Return the rays of a camera, given x, k and tangent_k at its position."""
    top_k = k_of(atmosphere, atmosphere.thickness)
    half_chord = safe_sqrt(top_k - tangent_k)
    c = k - top_k
    outside = c > 0.0
    misses = (tangent_k >= top_k) | ((c >= 0.0) & (x >= 0.0))
    start = np.where(outside & ~misses, c / np.maximum(half_chord - x, 1e-30), 0.0)
    return Ray(
        x=np.where(outside, -half_chord, x),
        k=np.where(outside, top_k, k),
        tangent_k=tangent_k,
        start=start,
        air=np.where(misses, -1.0, np.where(outside, 2.0 * half_chord, far_root(x, c, half_chord))),
    )


def ground_distance(ray):
    """Return the distance [m] from the base point to the ground, negative where the ray does not meet it ahead."""
    hits = (ray.tangent_k < 0.0) & (ray.x < 0.0)
    distance = np.maximum(ray.k, 0.0) / np.where(hits, safe_sqrt(-ray.tangent_k) - ray.x, 1.0)
    return np.where(hits, distance, -1.0)


def ray_from_points(atmosphere, origins, directions) -> Ray:
    """Return the rays of points (N, 3) [m] along unit directions (N, 3).

    The tangent point's k comes from the moment |origin x direction| where the origin is far, and from the origin's
    altitude where it is near: each form keeps its digits where the other loses them.
    """
    radius = atmosphere.bottom_radius
    r = np.linalg.norm(origins, axis=1)
    x = np.einsum("ij,ij->i", origins, directions)
    k = (r - radius) * (r + radius)
    impact = np.linalg.norm(np.cross(origins, directions), axis=1)
    far = r > 2.0 * radius
    return make_ray(atmosphere, x, k, np.where(far, (impact - radius) * (impact + radius), k - x * x))
