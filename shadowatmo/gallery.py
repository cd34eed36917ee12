"""The demo sets as data: which pictures there are, what each one shows, and from where.

Each picture of the set "main" is chosen to show one thing that an atmosphere must get right; the set "presets" shows
each planet from space, from within its air, and at sunset; "eclipses" has a file of its own, gallery_eclipses.py.
Cameras stand at real places; suns are set by azimuth and elevation at the camera, or along an axis of the planet where
only their angle to the camera matters.
"""

import math

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.errors import ParameterError
from shadowatmo.gallery_eclipses import eclipses
from shadowatmo.picture import Picture
from shadowatmo.places import bearing, place
from shadowatmo.validation import choice
from shadowatmo.worlds import WORLDS

DEG = math.pi / 180.0
SETS = ("main", "presets", "eclipses", "all")


def _above(world, latitude, longitude, height) -> np.ndarray:
    """Return the point (3,) [m] at a height above the ground [m]; angles in degrees."""
    planet = WORLDS[world]
    below = place(planet.radius, latitude * DEG, longitude * DEG)
    return place(planet.radius, latitude * DEG, longitude * DEG, height + planet.ground.altitude(below))


def _standing(world, at, sun, look, fov) -> dict:
    """Return scene and camera at (latitude, longitude, height), for sun and look as (azimuth, elevation) [degrees]."""
    position = _above(world, *at)
    scene = WORLDS[world].scene(bearing(position, sun[0] * DEG, sun[1] * DEG))
    forward = bearing(position, look[0] * DEG, look[1] * DEG)
    return {"scene": scene, "camera": Camera(position=position, forward=forward, up=position, vertical_fov=fov * DEG)}


def _facing(world, at, sun, fov, target=(0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0)) -> dict:
    """Return scene and camera at `at` (3,) [radii] looking to `target` [radii], for a sun in a direction (3,)."""
    planet = WORLDS[world]
    position, target = np.multiply(at, planet.radius), np.multiply(target, planet.radius)
    camera = Camera(position=position, target=target, up=up, vertical_fov=fov * DEG)
    return {"scene": planet.scene(sun), "camera": camera}


def _globe(world, latitude, longitude, distance, sun, fov=45.0) -> dict:
    """Return a globe from above a place [degrees] at a distance [radii]; the sun stands over (latitude, longitude)."""
    toward = place(1.0, sun[0] * DEG, sun[1] * DEG)
    return _facing(world, place(distance, latitude * DEG, longitude * DEG), toward, fov)


def pictures(which="main") -> tuple[Picture, ...]:
    """Return the pictures of a set, one of SETS, in the order in which they are drawn.

    Raises
    ------
    ParameterError
        If there is no such set.
    """
    sets = {"main": (_earth, _paper, _mars), "presets": (_presets,), "eclipses": (eclipses,)}
    wanted = sets if choice("set", which, SETS) == "all" else (which,)
    return tuple(picture for name in wanted for part in sets[name] for picture in part())


def _earth():
    return (
        Picture(
            "earth_orbit_day",
            "Africa by day from 13 500 km: blue haze thickens toward the limb, the terminator lies in the west.",
            **_globe("earth", 15, 25, 3.12, (8, 62)),
        ),
        Picture(
            "limb_sunset",
            "Sunset from 400 km: the sun's disc stands in the air of the limb, ozone keeps the upper layers blue; "
            "the sea mirrors the glow, the Azores lie dark in it.",
            **_standing("earth", (30, -10, 4e5), (285, -18.4), (290, -19.5), 24),
        ),
        Picture(
            "shadow_side",
            "The planet's shadow from the side, at 900 km: day ends in violet twilight where the shadow cuts the air.",
            **_standing("earth", (10, 95, 9e5), (276, -4.5), (356, -29), 45),
        ),
        Picture(
            "ground_sunset",
            "Two metres above the plain of Mendoza: the sun stands 2.3 degrees high above the Andes, in a yellow glow "
            "under a sky that stays gray-blue by light scattered more than once.",
            **_standing("earth", (-33.0, -68.4, 2.0), (264, 2.3), (268, 4), 28),
        ),
        Picture(
            "altitude_10km",
            "From 10 km over the Red Sea: haze veils land and water and whitens toward the horizon, 360 km away.",
            **_standing("earth", (28.2, 33.6, 1e4), (110, 35), (330, -14), 60),
        ),
    )


def _paper():
    behind = (-40.0, 0.45, 0.2)
    return (
        Picture(
            "night_ring",
            "The night side from 250 000 km: air beyond the limb is lit all around and rings the dark disc.",
            **_facing("earth", behind, (1, 0, 0), 3.4),
        ),
        Picture(
            "widths",
            "Path lengths that the depth passes find: amber where the air is lit, blue where the planet shades it.",
            **_facing("earth", (-0.35, -1.35, 0.4), (1, 0, 0), 50, (-0.1, -0.2, 0.75)),
            style="widths",
        ),
        Picture(
            "method_widths",
            "The published method: brightness by widths alone, 3 (lit + 0.2 shadowed).",
            **_globe("earth", 15, 25, 3.12, (8, 62)),
            quality={"method": "widths"},
        ),
        Picture(
            "camera_inside_cone",
            "From within the planet's umbra: no cap is missing where the near plane cuts the cone (right: widths).",
            **_facing("earth", (-0.2, 0.995, 0.0), (1, 0, 0), 40, (0.3, 0.95, 0.0), (0.0, 1.0, 0.0)),
            style="split",
            quality={"shadow": "cone"},
        ),
        Picture(
            "very_close",
            "Ten metres above the air. Left: the published 24-bit depth with its steps; right: 32 bits, without steps.",
            **_standing("earth", (20, -60, 60010.0), (90, 8), (60, -12), 50),
            left={"depth_bits": 24},
        ),
    )


def _mars():
    return (
        Picture(
            "mars_day",
            "Mars from 300 km by day: the dusty limb is white toward the sun, on the left, and tan away from it.",
            **_standing("mars", (-12, -70, 3e5), (250, 20), (280, -24), 45),
        ),
        Picture(
            "mars_sunset",
            "Sunset on Mars from two metres: dust scatters forward into a wide whitish glow around a small sun; away "
            "from it the sky is a dim gray-brown.",
            **_standing("mars", (-4.6, 137.4, 2.0), (280, 3), (277, 6), 45),
        ),
    )


# Height of the picture from within the air, and what the pictures from space, from there and at sunset show. The height
# is 20 km where the air is about as thick as the Earth's, and a third of the air's thickness elsewhere.
_PRESETS = {
    "earth": (2e4, "20 km", (
        "blue haze over Africa, and the sun's glint on the sea off Arabia.",
        "the Gulf of Suez below a dark blue sky; haze whitens the land toward the horizon.",
        "a yellow glow around the sun under a gray-blue sky, and its glitter on the sea.",
    )),
    "mars": (2e4, "20 km", (
        "tan ground under thin dust, soft at limb and terminator.",
        "dust scatters forward; the horizon shines toward the sun, the sky away from it is nearly black.",
        "a whitish glow of dust around a small sun.",
    )),
    "thin_earth": (2e4, "20 km", (
        "with a fifth of the air the ground keeps its colors, and only the limb is blue.",
        "a nearly black sky and a thin blue line along the horizon.",
        "the sun stays white and the sky blue.",
    )),
    "dense_earth": (2e4, "20 km", (
        "five times the air covers the continents with a lilac haze.",
        "no horizon is left between the haze and the sky.",
        "blue and green are scattered away, a red glow under a pink sky.",
    )),
    "titan": (1.3e5, "130 km, a third of the air,", (
        "orange haze, so deep that the limb fades gradually.",
        "haze without a horizon, brightest toward the sun.",
        "the haze absorbs blue, and hardly any light comes straight; the sky is brightest high above the sun.",
    )),
    "toy_planet": (660.0, "660 m, a third of the air,", (
        "air a fifth of the radius thick wraps a pale ground in blue.",
        "the horizon is a bow 20 degrees below the eye.",
        "a pale yellow glow, and a horizon that bends down at the sides.",
    )),
}  # fmt: skip


def _presets():
    for name, (height, words, shown) in _PRESETS.items():
        planet = WORLDS[name]
        dip = math.acos(planet.radius / (planet.radius + height)) / DEG
        far = 3.0 * planet.atmosphere.top_radius / planet.radius
        yield Picture(
            f"{name}_space",
            f"{name.upper()} from space: {shown[0]}",
            **_globe(name, 15, 25, far, (8, 85)),
        )
        yield Picture(
            f"{name}_aloft",
            f"{name.upper()} from {words} by day: {shown[1]}",
            **_standing(name, (28.2, 33.6, height), (285, 35), (330, -dip - 4.0), 60),
        )
        yield Picture(
            f"{name}_low_sun",
            f"{name.upper()} from two metres, the sun 3 degrees high: {shown[2]}",
            **_standing(name, (36.5, -14.0, 2.0), (270, 3), (268, 7), 45),
        )


def select(names=None, which="main") -> tuple[Picture, ...]:
    """Return the pictures of the given names in the sets' order, whatever their set; a whole set without names.

    Raises
    ------
    ParameterError
        If a name is unknown; the message lists the known ones.
    """
    if names is None:
        return pictures(which)
    known = pictures("all")
    for name in names:
        if name not in {p.name for p in known}:
            raise ParameterError("picture", name, "one of " + ", ".join(p.name for p in known))
    return tuple(p for p in known if p.name in names)
