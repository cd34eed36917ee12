"""Segments and shadow intervals: closed forms, far origins, grazing rays, membership of sampled points."""

from dataclasses import replace
from math import isqrt

import numpy as np
import pytest

from shadowatmo.intervals import cones, disc_cones, planet_shadow, sphere_crossings, trace
from shadowatmo.parameters import Sun
from shadowatmo.presets import EARTH
from shadowatmo.rays import Rays

R, TOP = EARTH.bottom_radius, EARTH.top_radius
SMALL = replace(EARTH, bottom_radius=10e3, top_radius=12e3, ozone=None)
SUN = Sun((1, 0, 0))
# x of a sphere of 2e5 m whose umbra, with the sun at 1.5e11 m, ends 30 km over the ground: x - apex = q (D -
# x)
_Q = 2e5 / (SUN.radius - 2e5)
APEX_CENTER = (R + 30e3 + _Q * 1.5e11) / (1 + _Q)


def segment(origin, direction, t_max=None, atmosphere=EARTH):
    return trace(atmosphere, Rays.validated(origin, direction, t_max))


def random_rays(count, seed=1, squeeze=(1.0, 1.0, 1.0)):
    """Rays from up to 10 radii toward points near the planet, drawn toward an axis by `squeeze`."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(2, count, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    origins = directions[0] * TOP * 10 ** rng.uniform(0, 1, (count, 1))
    targets = directions[1] * TOP * rng.uniform(0, 1.1, (count, 1)) * squeeze
    return Rays.validated(origins, targets - origins)


def test_ends_of_plain_rays():
    s = segment(
        [
            [R + 2, 0, 0],
            [R + 2, 0, 0],
            [R + 2, 0, 0],
            [2 * R, 0, 0],
            [2 * R, 0, 0],
            [2 * R, 0, 0],
            [2 * R, 0, 0],
        ],
        [[1, 0, 0], [-1, 0, 0], [1, 0, 0], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]],
        [np.inf, np.inf, 100, np.inf, np.inf, np.inf, 5],
    )
    assert s.end.tolist() == ["top", "ground", "t_max", "ground", "miss", "miss", "t_max"]
    # 2 m above 6.36e6 m: altitudes are multiples of 9e-10 m
    assert np.allclose(s.length, [TOP - R - 2, 2, 100, TOP - R, 0, 0, 0], rtol=0, atol=2e-9)
    assert np.allclose(s.t_end[[3, 6]], [R, 2 * R - TOP], rtol=0, atol=2e-9)
    assert np.isnan(s.t_in[4]) and np.isnan(s.t_out[5]) and np.isnan(s.t_end[4])


@pytest.mark.parametrize("altitude", [1e-3, 0.0, -1e-3, -10.0])
def test_origins_at_the_ground(altitude):
    s = segment([[R + altitude, 0, 0]] * 3, [[-1, 0, 0], [1, 0, 0], [1, 1, 0]])
    assert s.end.tolist() == ["ground", "top", "top"]
    assert s.length[0] == pytest.approx(max(altitude, 0.0), abs=2e-9)
    assert s.length[1] == pytest.approx(TOP - R - altitude, abs=2e-9)
    assert s.t_in.tolist() == [0, 0, 0]


def test_grazing_hit_from_a_millimeter():
    """Just under the horizon of an eye 1 mm up: the hit is 112 m away and has to keep its digits."""
    altitude = 2.0**-10
    power = altitude * (2 * R + altitude)
    sine = np.sqrt(power) / (R + altitude) * (1 + 1e-9)
    s = segment([[R + altitude, 0, 0]], [[-sine, np.sqrt(1 - sine**2), 0]])
    slope = (R + altitude) * sine
    assert s.end[0] == "ground"
    # the root of slope^2 - power, 5e-5 of slope: rounding of the direction gives 1e-16/1e-9 relative there
    assert s.length[0] == pytest.approx(power / (slope + np.sqrt(slope**2 - power)), rel=1e-9)


@pytest.mark.parametrize("distance", [1e6, 1e9, 1e11])
def test_far_origins_against_integer_arithmetic(distance):
    """A chord of the 12 km shell, seen from up to 1e11 m; integers give the exact answer."""
    offset = 11000.25
    s = segment([[distance, offset, 0.0]], [[-1, 0, 0]], atmosphere=SMALL)
    half = isqrt((48000**2 - 44001**2) * 10**24) / 10**12 / 4
    assert s.length[0] == pytest.approx(2 * half, abs=1e-10)
    assert s.t_in[0] == pytest.approx(distance - half, rel=3e-16)
    assert np.allclose(s.anchor[0], [half, offset, 0], rtol=0, atol=1e-10)


def test_far_oblique_origins_keep_the_impact_vector():
    """The same ray, moved back by a power of two of its direction, has the same segment."""
    direction = np.array([3.0, 4.0, 0.0]) / 5
    near = np.array([-4.0, 3.0, 0.0]) * 2210.0
    far = np.array([-4.0 * 2210.0 - 3 * 2.0**34, 3.0 * 2210.0 - 4 * 2.0**34, 0.0])  # exact: 8.6e10 m back
    a = segment([near - 5 * 2.0**12 * direction], [direction], atmosphere=SMALL)
    b = segment([far], [direction], atmosphere=SMALL)
    # 0.6 and 0.8 are not exact: 1e-16 of direction is 1e-5 m at 8.6e10 m, and the chord feels it fivefold
    assert b.length[0] == pytest.approx(a.length[0], abs=2e-4)


def contains(interval, s):
    return (s > interval[0][:, None]) & (s < interval[1][:, None])


def near_edge(interval, s, margin):
    return (np.abs(s - interval[0][:, None]) < margin) | (np.abs(s - interval[1][:, None]) < margin)


def samples(segments, count=101):
    s = segments.length[:, None] * (np.arange(count) + 0.5) / count
    return s, segments.points(s)


def test_planet_shadow_holds_the_points_of_its_definition():
    sun = np.array([2.0, -1.0, 2.0]) / 3
    segments = trace(EARTH, random_rays(500))
    interval = planet_shadow(segments, R, sun)
    s, x = samples(segments)
    inside = (x @ sun < 0) & (np.linalg.norm(np.cross(x, sun), axis=2) < R)
    wrong = (inside != contains(interval, s)) & ~near_edge(interval, s, 1e-3)
    assert inside.any() and not inside.all()
    assert not wrong.any()
    assert np.all(interval[0] <= interval[1]) and np.all(interval[1] <= segments.length)


@pytest.mark.parametrize(
    ("radius", "distance", "center"),
    [
        (R, 1.5e11, (0.0, 0, 0)),
        (R, 2e9, (0.0, 0, 0)),  # the antumbra begins 1.8e7 m behind the planet
        (1.7e6, 1.5e11, (3.7e8, 1e6, -2e6)),
        (1.7e6, 1.5e11, (4.1e8, 0, 0)),
        (8e8, 1.5e11, (3e9, 8.02e8, 0)),  # larger than the sun: the umbra widens
        (6.957e8, 1.5e11, (3e9, 6.98e8, 0)),  # as large as the sun: the umbra is a cylinder
        (2e5, 1.5e11, (APEX_CENTER, 0, 0)),  # its apex is in the air
    ],
)
def test_cones_hold_the_points_of_their_definition(radius, distance, center):
    sun = Sun((1, 0, 0), distance=distance)
    squeeze = (1, 0.05, 0.05) if center[0] == APEX_CENTER else (1, 1, 1)  # a thin shadow needs aiming
    segments = trace(EARTH, random_rays(500, seed=3, squeeze=squeeze))
    result = cones(segments, center, radius, sun)
    s, x = samples(segments)
    axis = np.array(center) - [distance, 0, 0]
    separation = np.linalg.norm(axis)
    axis /= separation
    w = x - center
    z, rho = w @ axis, np.linalg.norm(np.cross(w, axis), axis=2)

    def cone(sine):
        return radius / np.sqrt(1 - sine**2) - z * sine / np.sqrt(1 - sine**2)

    phi, psi = (sun.radius - radius) / separation, (sun.radius + radius) / separation
    beyond = z >= radius * phi
    expected = {
        "umbra": beyond & (rho <= cone(phi)) & (cone(phi) >= 0),
        "antumbra": beyond & (rho <= -cone(phi)),
        "outer": (z >= -radius * psi) & (rho <= cone(-psi)),
    }
    assert expected["outer"].any()
    for name, inside in expected.items():
        interval = getattr(result, name)
        wrong = (inside != contains(interval, s)) & ~near_edge(interval, s, 1.0)
        assert not wrong.any(), name
        assert np.isfinite(interval).all() and np.all(interval[0] <= interval[1])


def test_ray_along_the_axis_passes_the_apex():
    sun = Sun((1, 0, 0), distance=1.5e11)
    radius, center, apex = 2e5, (APEX_CENTER, 0.0, 0.0), R + 30e3
    segments = segment([[2 * R, 0, 0]], [[-1, 0, 0]])
    result = cones(segments, center, radius, sun)
    lengths = [interval[1][0] - interval[0][0] for interval in result]
    # positions near 4e7 m from the sphere round to 7e-9 m
    assert np.allclose(lengths, [TOP - apex, apex - R, TOP - R], rtol=0, atol=1e-6)


def test_bodies_that_touch_cast_no_shadow():
    segments = trace(EARTH, random_rays(20))
    result = cones(segments, (1.4e11, 0, 0), 1e10, SUN)
    assert all(np.all(interval[0] == interval[1]) for interval in result)


def test_disc_cones_bracket_the_parallel_shadow():
    segments = trace(EARTH, random_rays(300))
    full, partial = disc_cones(segments, R, SUN)
    parallel = planet_shadow(segments, R, SUN.direction)
    length = [interval[1] - interval[0] for interval in (full, parallel, partial)]
    # 1e-6 m: where all three end at the ground or the top
    assert np.all(length[0] <= length[1] + 1e-6) and np.all(length[1] <= length[2] + 1e-6)
    assert np.any(length[0] < length[1] - 100) and np.any(length[1] < length[2] - 100)


def test_sphere_crossings_have_their_altitude():
    segments = trace(EARTH, random_rays(300))
    s = np.stack(sphere_crossings(segments, R, 25e3), axis=1)
    inside = (s > 0) & (s < segments.length[:, None])
    crossing = inside & (np.abs(s + segments.slope[:, None]) > 1.0)  # else the tangent point of a higher line
    assert np.allclose(segments.altitude(s, R)[crossing], 25e3, rtol=0, atol=1e-6)
    assert crossing.sum() > 50
