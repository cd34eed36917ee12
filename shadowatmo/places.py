"""Places and directions on a planet: latitude, longitude and altitude to metres, compass bearings to vectors.

The planet is a sphere about the origin; longitude 0 lies on +x, 90 degrees east on +y, the north pole on +z, as in
`Surface`. Azimuths run clockwise from north. All angles are in radians.
"""

import math

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.validation import number

POLE = 1e-9  # distance from the axis, of a unit vector, below which longitude 0 decides where east is


def place(radius, latitude, longitude, altitude=0.0) -> np.ndarray:
    """Return the point (3,) [m] above a sphere of `radius` [m] at latitude and longitude [rad] and altitude [m]."""
    latitude = number("latitude", latitude, low=-math.pi / 2, high=math.pi / 2)
    longitude, altitude = number("longitude", longitude), number("altitude", altitude)
    return (radius + altitude) * np.array(
        [math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude)]
    )


def local_axes(position) -> np.ndarray:
    """Return east, north and up at a point (3,) as the rows of a (3, 3) rotation."""
    radius = np.linalg.norm(position)
    if not radius > 0.0:
        raise ParameterError("position", tuple(position), "a point other than the planet's center")
    up = np.asarray(position, np.float64) / radius
    east = np.array([-up[1], up[0], 0.0])
    length = np.linalg.norm(east)
    east = east / length if length > POLE else np.array([0.0, 1.0, 0.0])
    return np.array([east, np.cross(up, east), up])


def bearing(position, azimuth, elevation) -> np.ndarray:
    """Return the unit vector (3,) that points from `position` to azimuth and elevation above the horizontal [rad]."""
    local = (
        math.sin(azimuth) * math.cos(elevation),
        math.cos(azimuth) * math.cos(elevation),
        math.sin(elevation),
    )
    return np.array(local) @ local_axes(position)


def azimuth_elevation(position, direction) -> tuple[float, float]:
    """Return azimuth in [0, 2 pi) and elevation of a direction (3,) seen from `position` [rad]."""
    east, north, up = local_axes(position) @ (np.asarray(direction, np.float64) / np.linalg.norm(direction))
    return math.atan2(east, north) % (2.0 * math.pi), math.atan2(up, math.hypot(east, north))


def rotate(vector, axis, angle) -> np.ndarray:
    """Return a vector (3,) turned by `angle` [rad] about a unit axis (3,), right-handed (Rodrigues)."""
    vector, axis = np.asarray(vector, np.float64), np.asarray(axis, np.float64)
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * vector + sine * np.cross(axis, vector) + (1.0 - cosine) * (axis @ vector) * axis


class Ground:
    """Altitude of the ground, as the terrain pass draws it: the height map under a cubic B-spline.

    Parameters
    ----------
    surface : Surface or None
        Without one, or without a height map, the ground is at altitude 0 everywhere.
    """

    def __init__(self, surface):
        self._height = None if surface is None else surface.load_height()

    def altitude(self, position) -> float:
        """Return the altitude [m] of the ground below a point (3,)."""
        if self._height is None:
            return 0.0
        rows, columns = self._height.shape
        x, y, z = position
        u = (math.atan2(y, x) / (2.0 * math.pi) + 0.5) * columns - 0.5
        v = (0.5 - math.atan2(z, math.hypot(x, y)) / math.pi) * rows - 0.5
        column, row = math.floor(u), math.floor(v)
        across = np.arange(column - 1, column + 3) % columns
        down = np.clip(np.arange(row - 1, row + 3), 0, rows - 1)
        return float(_spline(v - row) @ self._height[np.ix_(down, across)] @ _spline(u - column))


def _spline(f) -> np.ndarray:
    """Return the four weights of a uniform cubic B-spline at the fraction f of a cell."""
    return np.array([(1 - f) ** 3, 4 - 6 * f**2 + 3 * f**3, 1 + 3 * f + 3 * f**2 - 3 * f**3, f**3]) / 6.0
