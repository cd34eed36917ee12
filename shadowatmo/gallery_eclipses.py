"""The demo set "eclipses" as data: shadows of moons from space, from the air and from within, and two suns.

Sun and moon of the real eclipses stand here as `sky_at` placed them, so that the pictures need no ephemeris; a test
compares. The moons of the large planet have the sizes and distances of Jupiter's.
"""

import math
from dataclasses import replace

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.ephemeris import MOON_RADIUS, SUN_RADIUS, Sky
from shadowatmo.parameters import Atmosphere, Occluder, Sun
from shadowatmo.picture import Picture
from shadowatmo.places import bearing, local_axes, place, rotate
from shadowatmo.scene import Scene
from shadowatmo.surface import Surface
from shadowatmo.worlds import ASTRONOMICAL_UNIT, WORLDS

DEG = math.pi / 180.0
EARTH = WORLDS["earth"]
# name: date, observer (degrees, m), and what `observing.observed` makes of them: centers of sun and moon, and the
# observer's place in the scene [m]
SKIES = {
    "madras": (
        "2017-08-21T17:20:35Z", (44.633, -121.129, 690.0),
        (27267999691, -145553487119, 31144643904), (63920883, -357519584, 80137432), (-2340027, -3874672, 4468838),
    ),
    "kentucky": (
        "2017-08-21T18:25:30Z", (36.967, -87.672, 150.0),
        (-14505795174, -147380373251, 31105314887), (-34914940, -361893645, 79125767), (206417, -5077462, 3824716),
    ),
    "albuquerque": (
        "2023-10-14T16:36:54Z", (35.0844, -106.6504, 1600.0),
        (43865672752, -141028829615, -21341480557), (114159667, -376757944, -52605962), (-1491614, -4987493, 3656556),
    ),
}  # fmt: skip

# Like Jupiter, without its bands. Mean radius, at 1 bar, and scale height: Williams, Jupiter Fact Sheet (NASA).
# Rayleigh scattering of 86 % hydrogen at 1 bar and 165 K, to which helium adds nearly nothing, by the cross section of
# Dalgarno and Williams 1962 at 680, 550 and 440 nm. Over the ammonia clouds, the ground here, lies a thin haze (between
# 150 and 500 mbar: Sato and Hansen 1979), of an optical depth of 0.4 here, that absorbs blue. The clouds have that
# color, and an albedo for which the whole reflects about the half of sunlight (geometric albedo 0.52: Fact Sheet).
JUPITER = Atmosphere(
    bottom_radius=6.9911e7,
    top_radius=7.0161e7,
    rayleigh_scattering=(1.5e-6, 3.6e-6, 9.0e-6),
    rayleigh_scale_height=2.7e4,
    mie_scattering=(1.49e-5, 1.46e-5, 1.32e-5),
    mie_extinction=(1.5e-5, 1.5e-5, 1.5e-5),
    mie_scale_height=2.7e4,
    mie_g=0.7,
    ground_albedo=(0.62, 0.54, 0.43),
)
# Orbit and radius [m] (Fact Sheet), and how far to the east and north of the axis the shadow is to fall [radii]
IO, EUROPA = (4.218e8, 1.8216e6, 0.35, -0.3), (6.711e8, 1.5608e6, -0.05, 0.05)
GANYMEDE = (1.0704e9, 2.6312e6, -0.45, 0.35)
JUPITER_SUN = Sun(direction=(1.0, 0.0, 0.0), distance=5.203 * ASTRONOMICAL_UNIT)

COMPASS = (("north", 0.0), ("east", 90.0), ("south", 180.0), ("west", 270.0))


def eclipses():
    """Return the pictures of the set."""
    return (*_from_space(), *_from_within(), *_annular(), _jupiter(), *_two_suns())


def sky(name) -> Sky:
    """Return one of SKIES."""
    _, _, sun, moon, position = SKIES[name]
    return Sky(Sun(direction=sun, distance=float(np.linalg.norm(sun)), radius=SUN_RADIUS), Occluder(moon, MOON_RADIUS),
               position)  # fmt: skip


def _above(latitude, longitude, height) -> np.ndarray:
    """Return the point (3,) [m] at a height above the Earth's ground; angles in degrees."""
    below = place(EARTH.radius, latitude * DEG, longitude * DEG)
    return place(EARTH.radius, latitude * DEG, longitude * DEG, height + EARTH.ground.altitude(below))


def _toward(position, target, fov, up=None):
    """Return a camera at a point (3,) [m] that looks to another, fov in degrees."""
    up = position if up is None else up
    return Camera(position=position, target=target, up=up, vertical_fov=fov * DEG)


def _looking(position, azimuth, elevation, fov) -> Camera:
    """Return a camera at a point (3,) [m] that looks to azimuth and elevation; angles in degrees."""
    forward = bearing(position, azimuth * DEG, elevation * DEG)
    return Camera(position=position, forward=forward, up=position, vertical_fov=fov * DEG)


def _from_space():
    kentucky, madras = sky("kentucky"), sky("madras")
    moon = np.array(kentucky.moon.center)
    beside = rotate(moon, local_axes(moon)[1], 14.0 * DEG)
    spot = np.array(madras.position)
    return (
        Picture(
            "shadow_from_moon",
            "21 August 2017, 18:26, from as far as the Moon: its shadow over Kentucky, a dark core of 110 km in a veil "
            "of 7000 km; the sun glints on the sea south of it.",
            kentucky.scene(),
            _toward(beside, (0.0, 0.0, 0.0), 2.3, (0.0, 0.0, 1.0)),
        ),
        Picture(
            "shadow_from_400km",
            "The same shadow an hour before from 400 km above the Pacific: it covers Oregon.",
            madras.scene(),
            _toward(_above(40.5, -127.5, 4e5), spot, 50),
        ),
        Picture(
            "shadow_from_10km",
            "Beside it, 10 km high, 80 km from its middle: dark ground under a dark sky, and day beyond.",
            madras.scene(),
            _looking(_above(44.9, -122.1, 1e4), 111.0, -6.0, 65.0),
            compensation=0.3,
        ),
    )


def _from_within():
    madras = sky("madras")
    for name, azimuth in COMPASS:
        yield Picture(
            f"totality_{name}",
            f"Totality in Madras, Oregon, to the {name}: light comes from beyond the shadow, all around the horizon.",
            madras.scene(),
            madras.camera(azimuth * DEG, 18.0 * DEG, 58.0 * DEG),
            compensation=0.3,
        )
    yield Picture(
        "totality_fisheye",
        "The whole sky of totality: north at the top, east on the left, the horizon at the rim.",
        madras.scene(),
        madras.camera(),
        style="fisheye",
        compensation=0.3,
    )


def _annular():
    albuquerque = sky("albuquerque")
    return (
        Picture(
            "annular_sky",
            "14 October 2023, Albuquerque: a ring of the sun remains, and a tenth of the day's light.",
            albuquerque.scene(),
            albuquerque.camera(elevation=19.0 * DEG, vertical_fov=46.0 * DEG),
        ),
        Picture(
            "annular_ring",
            "The ring itself, one degree of sky: darker toward the limb, broken by nothing.",
            albuquerque.scene(),
            albuquerque.camera(vertical_fov=0.8 * DEG),
            exposure=1e-4,  # of its own: at any other the ring is white throughout
        ),
    )


def _jupiter() -> Picture:
    moons = []
    for orbit, radius, *aside in (IO, EUROPA, GANYMEDE):
        east, north = np.multiply(aside, JUPITER.bottom_radius)
        moons.append(Occluder((math.sqrt(orbit**2 - east**2 - north**2), east, north), radius))
    scene = Scene(atmosphere=JUPITER, suns=JUPITER_SUN, occluders=moons, surface=Surface())
    position = 3.4 * JUPITER.bottom_radius * np.array([math.cos(0.4), math.sin(-0.4), 0.12])
    return Picture(
        "jupiter_shadows",
        "Shadows of Io (lower right), Europa and Ganymede on a planet of Jupiter's size, true to scale; the real three "
        "never stand so at once, for their orbits are in step.",
        scene,
        _toward(position, (0.0, 0.0, 0.0), 37.0, (0.0, 0.0, 1.0)),
    )


def _two_suns():
    position = _above(36.5, -14.0, 2.0)
    white = EARTH.scene(bearing(position, 262 * DEG, 9.0 * DEG)).suns[0]
    orange = replace(
        white, direction=bearing(position, 275 * DEG, 3.5 * DEG), radius=2.2 * white.radius, irradiance=(0.9, 0.5, 0.22)
    )
    ground = replace(EARTH.scene((1, 0, 0)), suns=(white, orange))
    noon = place(1.0, 21.0 * DEG, 8.0 * DEG)
    pair = [Sun(direction=rotate(noon, (0, 0, 1), -1.5 * DEG), irradiance=(0.4, 0.65, 1.0))]
    pair.append(replace(pair[0], direction=rotate(noon, (0, 0, 1), 1.5 * DEG), irradiance=(1.0, 0.55, 0.2)))
    moon = Occluder(5.5e7 * noon, 5e5)
    yield Picture(
        "two_suns_set",
        "Two suns over the sea, a small white one and a large orange one, each with its glow and its glitter.",
        ground,
        _looking(position, 268.0, 7.0, 40.0),
    )
    yield Picture(
        "two_suns_shadows",
        "A blue and an orange sun three degrees apart, one moon, two shadows, each in the other's light.",
        replace(EARTH.scene(noon), suns=tuple(pair), occluders=moon),
        _toward(place(2.3 * EARTH.radius, 12.0 * DEG, 14.0 * DEG), (0.0, 0.0, 0.0), 52.0, (0.0, 0.0, 1.0)),
    )
