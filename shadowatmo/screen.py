"""Which part of a picture can show a sphere: a window of pixels that holds it for sure.

Windows are (left, bottom, right, top) in whole pixels, counted from the lower left corner as OpenGL does; right and top
are the first that are not in it.
"""

import math

import numpy as np

PIXEL = 1.0  # margin about a window: what float32 may make of the place of an edge


def sphere_window(camera, size, center, radius) -> tuple[int, int, int, int] | None:
    """Return the window of the pixels whose rays may meet a sphere, or None where none does.

    Parameters
    ----------
    camera : Camera
        Whose picture.
    size : (int, int)
        Width and height of the picture [pixels].
    center : (3,) float
        The sphere's, from the camera on, along the planet-centered axes [m].
    radius : float
        The sphere's [m].

    Notes
    -----
    Seen along the picture's other axis the sphere is a disc, and the slopes of the rays that meet it are those between
    two tangents; so both sides are exact, also where the sphere is partly behind the camera.
    """
    relative = camera.basis() @ np.array(center)
    if math.hypot(*relative) <= radius:
        return 0, 0, *size
    sides = []
    for across, tangent, pixels in zip(relative, camera.tangents(size), size, strict=False):
        angles = _angles_ahead(across, relative[2], radius)
        if angles is None:
            return None
        low, high = (0.5 * pixels * (1.0 + math.tan(angle) / tangent) for angle in angles)
        first = math.floor(min(max(low - PIXEL, 0.0), pixels))
        last = math.ceil(min(max(high + PIXEL, 0.0), pixels))
        if first >= last:
            return None
        sides.append((first, last))
    return sides[0][0], sides[1][0], sides[0][1], sides[1][1]


def _angles_ahead(across, ahead, radius):
    """Return the least and largest angle [rad] from the view axis of rays in a plane that meet a disc; None: behind."""
    distance = math.hypot(across, ahead)
    if distance <= radius:
        return -0.5 * math.pi, 0.5 * math.pi
    middle, half = math.atan2(across, ahead), math.asin(radius / distance)
    found = []
    for turn in (-2.0 * math.pi, 0.0, 2.0 * math.pi):
        low, high = max(middle - half + turn, -0.5 * math.pi), min(middle + half + turn, 0.5 * math.pi)
        found += [low, high] if low < high else []
    return (min(found), max(found)) if found else None


def area(window) -> int:
    """Return how many pixels a window has; None has none."""
    return 0 if window is None else (window[2] - window[0]) * (window[3] - window[1])


def holds(outer, inner) -> bool:
    """Return whether a window holds another one."""
    return outer[0] <= inner[0] and outer[1] <= inner[1] and outer[2] >= inner[2] and outer[3] >= inner[3]


def meet(one, other) -> bool:
    """Return whether two windows have a pixel in common."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def around(one, other) -> tuple[int, int, int, int]:
    """Return the smallest window that holds two."""
    return *(min(a, b) for a, b in zip(one[:2], other[:2], strict=True)), *(
        max(a, b) for a, b in zip(one[2:], other[2:], strict=True)
    )


def in_steps(window, step, size) -> tuple[int, int, int, int]:
    """Return a window widened to multiples of `step` pixels, within a picture of `size`."""
    low = (n // step * step for n in window[:2])
    high = (min(-(-n // step) * step, most) for n, most in zip(window[2:], size, strict=True))
    return *low, *high


def frame_around(window, size) -> list[tuple[int, int, int, int]]:
    """Return the windows, up to four, that a picture of `size` has around a window; all of it around None."""
    if window is None:
        return [(0, 0, *size)]
    left, bottom, right, top = window
    parts = [
        (0, 0, size[0], bottom),
        (0, top, *size),
        (0, bottom, left, top),
        (right, bottom, size[0], top),
    ]
    return [part for part in parts if area(part) > 0]
