"""The cameras that pixels are judged with: from 2 m to 1e9 m, in light, at the terminator, in the planet's shadow."""

import numpy as np

import shadowatmo as sa

R = sa.EARTH.bottom_radius
SUN = sa.Sun(direction=(1.0, 0.0, 0.0))


def above(zenith, altitude):
    """Return a point [m] where the sun's zenith angle is `zenith` degrees."""
    angle = np.radians(zenith)
    return (R + altitude) * np.array([np.cos(angle), np.sin(angle), 0.0])


def level(zenith, altitude, azimuth, elevation, fov=60.0):
    """Return a camera that looks `elevation` degrees above the horizontal, `azimuth` degrees from the sun's."""
    up = above(zenith, 0.0) / R
    sunward = np.array([up[1], -up[0], 0.0])
    a, e = np.radians(azimuth), np.radians(elevation)
    forward = np.cos(e) * (np.cos(a) * sunward + np.sin(a) * np.array([0.0, 0.0, 1.0])) + np.sin(e) * up
    return sa.Camera(position=above(zenith, altitude), forward=forward, up=up, vertical_fov=np.radians(fov))


def facing(direction, distance, fov):
    """Return a camera that looks at the planet's center from far away."""
    d = np.array(direction, float)
    return sa.Camera(position=distance * d / np.linalg.norm(d), target=(0, 0, 0), vertical_fov=np.radians(fov))


CAMERAS = {
    "2 m, noon": level(30, 2.0, 0, 5),
    "2 m, sunset": level(88, 2.0, 20, 5),
    "2 m, twilight, away from the sun": level(93, 2.0, 170, 10),
    "2 m, deep night": level(130, 2.0, 0, 20),
    "1 km, on the shadow's edge": level(91, 1e3, 90, 5),
    "10 km, low sun": level(80, 1e4, 0, -8),
    "59 km, dusk": level(97, 5.9e4, 45, -3),
    "400 km, day": level(60, 4e5, 0, -22),
    "400 km, sunset": level(104, 4e5, 0, -18),
    "20 000 km, half phase": facing((0.1, 1.0, 0.3), 2e7, 45),
    "Moon's distance, crescent": facing((-0.9, 0.5, 0.1), 3.844e8, 2.2),
    "1e9 m, behind the planet": facing((-1.0, 0.03, 0.02), 1e9, 0.9),
}
