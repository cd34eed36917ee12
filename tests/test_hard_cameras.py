"""Eyes and suns in awkward places: from a meter under the ground to 1e11 m away, against the float64 twin."""

import numpy as np
import pytest

import shadowatmo as sa
from tests.hard_cases import QUALITY, SUNS, Compared, check_change, direction, ray_fan, turned

EARTH = sa.EARTH
R = EARTH.bottom_radius
# The fit of the closed form (2e-5 of an optical depth), float32, and 12 nodes in the dark over 1700 km.
TRANSMITTANCE = 1e-4
# Relative, of light down to 1e-4 of the rays' brightest: sunlight that grazes the ozone layer, whose sides are taken as
# straight over r^2, is 1.6e-3 off in the green; 1.5 times that.
LIGHT = 2.5e-3
# What float32 adds to a change of the input, relative to the light: the last digits of distances of 1000 km.
SMOOTH = 1e-4
ALTITUDES = {
    "1 m below the ground": -1.0,
    "1 mm": 1e-3,
    "2 m": 2.0,
    "100 m": 100.0,
    "on the top": EARTH.thickness,
    "36 000 km": 3.6e7,
    "the Moon's distance": 3.844e8,
    "1e9 m": 1e9,
    "1e11 m": 1e11,
}


def compared(ctx, sun, altitude, rays, air=EARTH):
    origins = np.tile([air.bottom_radius + altitude, 0.0, 0.0], (len(rays), 1))
    return Compared(ctx, sa.Scene(air, sa.Sun(sun)), origins, np.array(list(rays.values())), names=list(rays))


@pytest.mark.parametrize("place", ALTITUDES)
def test_eyes(ctx, place):
    altitude = ALTITUDES[place]
    for sun in SUNS.values():
        case = compared(ctx, sun, altitude, ray_fan(EARTH, altitude, sun))
        case.check_sane()
        case.check_ends()
        case.check(TRANSMITTANCE, "transmittance")
        case.check(LIGHT, "single", "ground_direct")
        # float32 near the planet; from afar the digits of the distance itself, 6e-8 of it, do not enter
        case.check(0.5, "lit", "shadow")
        # the finite cone's half angle is a difference of radii over a distance that float32 keeps to 1e-7
        case.check(2.0, "planet_umbra", "planet_penumbra")


@pytest.mark.parametrize("place", ALTITUDES)
def test_eyes_that_move_a_little(ctx, place):
    """A ray, a sun or an eye moved by 1e-6 changes the light by what the twin says, and a share of 1e-4."""
    altitude = ALTITUDES[place]
    step = 1e-6 * max(abs(altitude), 1.0)
    for sun in SUNS.values():
        rays = ray_fan(EARTH, altitude, sun)
        before = compared(ctx, sun, altitude, rays)
        moved = {name: ray for name, ray in zip(rays, turned(before_directions(rays), 1e-6), strict=True)}
        changes = [
            (sun, altitude, moved),
            (turned(np.array([sun]), 1e-6)[0], altitude, rays),
            (sun, altitude + step, rays),
        ]
        for change in changes:
            check_change(before, compared(ctx, *change), SMOOTH)


def before_directions(rays):
    return np.array(list(rays.values()))


def test_a_sloppy_shader_would_be_noticed(ctx):
    """The rejected case: 6 nodes, no top, do not pass."""
    sun = SUNS["80 degrees"]
    rays = ray_fan(EARTH, 2.0, sun)
    origins = np.tile([R + 2.0, 0.0, 0.0], (len(rays), 1))
    poor = sa.Quality(nodes=4, gap_nodes=2, orders=1)
    case = Compared(ctx, sa.Scene(EARTH, sa.Sun(sun)), origins, np.array(list(rays.values())), quality=poor)
    with pytest.raises(AssertionError):
        case.check(LIGHT, "single")


@pytest.mark.parametrize("offset", [0.0, 1e-9, -1e-9])
@pytest.mark.parametrize("altitude", [2.0, 4e5, 3.6e7])
def test_on_the_knife_edge_either_side_is_right(ctx, altitude, offset):
    """A ray that touches the ground to a hair may hit or miss it, and gets the light of one of the two."""
    sun = SUNS["80 degrees"]
    edge = -np.arccos(R / (R + altitude)) + offset
    rays = {"on it": edge, "above": edge + 2e-8, "below": edge - 2e-8}
    case = compared(ctx, sun, altitude, {name: direction(angle, 0.7) for name, angle in rays.items()})
    case.check_sane()
    for field in ("transmittance", "single"):
        found, twin = getattr(case.got, field)[0], getattr(case.twin, field)[1:]
        # 2e-8 radians at 36 000 km are a meter of tangent height
        errors = [np.max(np.abs(found - side) / (1.0 if field == "transmittance" else side.max())) for side in twin]
        assert min(errors) < 1e-2, field


def shadow_points(air, sun):
    """Return {name: point} in, on and at the apex of the planet's umbra, and on the parallel sun's cylinder."""
    radius, s = air.bottom_radius, np.array(sun.direction)
    sine = (sun.radius - radius) / sun.distance
    side = np.cross(s, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)

    def on_cone(z):
        return -z * s + (radius - z * sine) / np.sqrt(1.0 - sine * sine) * side

    return {
        "in the umbra": -5e7 * s,
        "in the umbra, in the air": -(radius + 10.0) * s,
        "on the cone, near": on_cone(1.0e7),
        "on the cone, far": on_cone(8.0e8),
        "at the apex": -radius / sine * s,
        "beyond the apex": -1.5 * radius / sine * s,
        # a ray along the cylinder itself touches the ground, and is lit or dark as rounding says: 1 mm decides it
        "1 mm outside the cylinder": -1.0e7 * s + (radius + 1e-3) * side,
        "1 mm inside the cylinder": -1.0e7 * s + (radius - 1e-3) * side,
        "on the terminator": (radius + 2.0) * side,
    }


PLACES = tuple(shadow_points(EARTH, sa.Sun((1, 0, 0))))


@pytest.mark.parametrize("place", PLACES)
def test_in_and_on_the_shadow(ctx, place):
    sun = sa.Sun((0.6, 0.8, 0.0))
    point = shadow_points(EARTH, sun)[place]
    rng = np.random.default_rng(3)
    # through the air all around the planet, and exactly along the axis, where nothing is across it
    toward = -point + rng.normal(size=(60, 3)) * 0.7 * R
    rays = np.concatenate([toward, [sun.direction, -np.array(sun.direction), -point]])
    case = Compared(ctx, sa.Scene(EARTH, sun), np.tile(point, (len(rays), 1)), rays)
    case.check_sane()
    # Rays chosen at random keep clear of the ozone's edge, but not of limb paths: the tolerances of all eyes.
    case.check(TRANSMITTANCE, "transmittance")
    case.check(LIGHT, "single", "ground_direct")
    distance = np.linalg.norm(point)
    case.check(0.5 + 1e-7 * distance, "lit", "shadow")
    # a ray along the cone's surface enters it where a difference of 1e-7 of the distance says
    case.check(2.0 + 3e-6 * distance, "planet_umbra", "planet_penumbra")


@pytest.mark.parametrize("place", PLACES)
def test_in_and_on_the_shadow_a_little_aside(ctx, place):
    """Rays turned and points moved by 1e-6: what changes is what changes in the twin, at the shadow's edge too."""
    sun = sa.Sun((0.6, 0.8, 0.0))
    point = shadow_points(EARTH, sun)[place]
    rays = -point + np.random.default_rng(4).normal(size=(60, 3)) * 0.7 * R
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    names = [f"ray {i}" for i in range(len(rays))]

    def seen(at, directions):
        return Compared(ctx, sa.Scene(EARTH, sun), np.tile(at, (len(rays), 1)), directions, names=names)

    before = seen(point, rays)
    step = 1e-6 * np.linalg.norm(point) * np.array([0.0, 0.6, 0.8])
    for after in (seen(point, turned(rays, 1e-6)), seen(point + step, rays)):
        check_change(before, after, SMOOTH)


@pytest.mark.parametrize("altitude", [2.0, 3e4, 4e5, 3.844e8])
def test_view_and_sun_almost_parallel(ctx, altitude):
    """From exactly parallel to 1e-6 aside the light changes as the twin's does, with the sun's light and against it."""
    directions = np.random.default_rng(6).normal(size=(12, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for sun in directions[:3]:
        side = np.cross(sun, [0.3, 0.5, -0.2])
        side /= np.linalg.norm(side)
        for sign in (1.0, -1.0):
            origins = np.array([(R + altitude) * sun, (R + altitude) * side, (R + 2e4) * side - sign * altitude * sun])
            cases = [
                Compared(
                    ctx, sa.Scene(EARTH, sa.Sun(sun)), origins, np.tile(turned(sign * sun[None], angle), (3, 1)),
                    names=["from above", "level", "limb"],
                )
                for angle in (0.0, 1e-9, 1e-6)
            ]  # fmt: skip
            for after in cases[1:]:
                check_change(cases[0], after, SMOOTH)


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("altitude", [2.0, 3e4, 4e5, 3.844e8])
def test_view_and_sun_parallel(ctx, altitude, offset):
    """Along the sun's light to the last bit, and a hair beside it: no angle is left to divide by."""
    rng = np.random.default_rng(5)
    directions = rng.normal(size=(12, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for sign in (1.0, -1.0):
        for d in directions[:6]:
            # at the height where the ray passes through the air
            side = np.cross(d, [0.3, 0.5, -0.2])
            side /= np.linalg.norm(side)
            origins = np.array([(R + altitude) * d, (R + altitude) * side, (R + 2e4) * side - sign * altitude * d])
            rays = np.tile(turned(sign * d[None], offset), (3, 1))
            case = Compared(ctx, sa.Scene(EARTH, sa.Sun(d)), origins, rays, names=["from above", "level", "limb"])
            case.check_sane()
            case.check(TRANSMITTANCE, "transmittance")
            case.check(LIGHT, "single", "ground_direct")
            case.check(0.5, "lit", "shadow")


def test_the_quality_tested_is_the_accurate_one():
    accurate = sa.quality.NAMED["accurate"]
    assert (QUALITY.nodes, QUALITY.terms, QUALITY.method) == (accurate.nodes, accurate.terms, accurate.method)
