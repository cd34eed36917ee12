"""The whole sky in one picture: five square views of a half cube, resampled to a disc about the zenith.

The disc is equidistant: the distance from its middle is the angle from the zenith. As in a map of the sky that is held
overhead, north is at the top and east on the left. Local directions are (east, north, up).
"""

import math

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.places import local_axes

EDGE = math.radians(95.0)  # angle from the zenith at the disc's rim: a little of the ground is in view
# view axis and top of the five faces: up, north, east, south, west
FACES = (
    ((0, 0, 1), (0, -1, 0)),
    ((0, 1, 0), (0, 0, 1)),
    ((1, 0, 0), (0, 0, 1)),
    ((0, -1, 0), (0, 0, 1)),
    ((-1, 0, 0), (0, 0, 1)),
)


def face_cameras(position) -> tuple[Camera, ...]:
    """Return the cameras of the five faces at a point (3,) [m]; each sees 90 degrees."""
    axes = local_axes(position)
    return tuple(
        Camera(position=position, forward=forward @ axes, up=top @ axes, vertical_fov=math.pi / 2.0)
        for forward, top in np.array(FACES, np.float64)
    )


def disc_directions(size) -> np.ndarray:
    """Return local unit vectors (h, w, 3) of the pixels of a picture of size (w, h); nan outside the disc."""
    width, height = size
    x = (np.arange(width) + 0.5 - width / 2.0) / (min(size) / 2.0)
    y = (height / 2.0 - np.arange(height) - 0.5) / (min(size) / 2.0)
    x, y = np.meshgrid(x, y)
    r = np.hypot(x, y)
    angle = np.where(r <= 1.0, r * EDGE, np.nan)
    across = np.sin(angle) / np.maximum(r, 1e-9)
    return np.stack([-x * across, y * across, np.cos(angle)], axis=-1)


def resample(faces, size) -> np.ndarray:
    """Return the radiances (h, w, 3) float32 of a disc, black around it.

    Parameters
    ----------
    faces : sequence of five (n, n, 3) arrays
        Radiances seen by `face_cameras`, row 0 at the top.
    size : (int, int)
        Width and height of the picture [pixels].
    """
    result = np.zeros((size[1], size[0], 3), np.float32)
    toward = disc_directions(size)
    rows, columns = np.nonzero(np.isfinite(toward[..., 2]))
    toward = toward[rows, columns]
    bases = np.array([(np.cross(forward, top), top, forward) for forward, top in FACES], np.float64)
    seen = np.argmax(toward @ bases[:, 2].T, axis=1)
    for number, face in enumerate(faces):
        mine = seen == number
        right, up, along = bases[number] @ toward[mine].T
        result[rows[mine], columns[mine]] = bilinear(np.asarray(face), right / along, up / along)
    return result


def bilinear(face, x, y) -> np.ndarray:
    """Return the values (N, 3) of a square picture (n, n, 3) at x to the right and y up, both (N,) in [-1, 1]."""
    n = len(face)
    column, row = (np.clip(n * 0.5 * (1.0 + v) - 0.5, 0.0, n - 1.0) for v in (x, -y))
    left, top = (np.minimum(v.astype(int), max(n - 2, 0)) for v in (column, row))
    right, below = (np.minimum(v + 1, n - 1) for v in (left, top))
    across, down = (column - left)[:, None], (row - top)[:, None]
    upper = face[top, left] * (1.0 - across) + face[top, right] * across
    lower = face[below, left] * (1.0 - across) + face[below, right] * across
    return upper * (1.0 - down) + lower * down
