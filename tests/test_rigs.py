"""Camera rigs and the sun's clock: what hands do, in numbers."""

import math

import numpy as np
import pytest

from shadowatmo.places import azimuth_elevation, bearing, local_axes
from shadowatmo.rigs import HIGHEST, LOWEST, FlyRig, SunRig, fly_from, orbit_above, orbit_from
from shadowatmo.worlds import world

EARTH = world("earth")
R = EARTH.radius
EXACT = 1e-9


def orbit(height=1e6, latitude=28.0, longitude=86.9):
    return orbit_above(EARTH, math.radians(latitude), math.radians(longitude), height)


def fly(height=1000.0, latitude=28.0, longitude=86.9):
    rig = orbit(height, latitude, longitude)
    return FlyRig(R, EARTH.ground, rig.position, local_axes(rig.up)[1])


def height_above_ground(position):
    return np.linalg.norm(position) - R - EARTH.ground.altitude(position)


def is_sound(rig):
    camera = rig.camera()
    basis = camera.basis()
    above = height_above_ground(rig.position)
    orthonormal = np.allclose(basis @ basis.T, np.eye(3), atol=EXACT)
    return orthonormal and LOWEST - 1e-3 <= above <= HIGHEST * (1 + EXACT)  # mm: float64 at the planet's radius


# --- orbit


def test_orbit_looks_at_the_center_from_far_away():
    rig = orbit(3e7)
    assert np.allclose(rig.camera().forward, -rig.up, atol=EXACT)


def test_orbit_looks_at_the_horizon_when_low():
    rig = orbit(5e4, 0.0, -30.0)
    dip = math.acos(R / (R + rig.altitude))
    assert azimuth_elevation(rig.position, rig.camera().forward)[1] == pytest.approx(-dip, abs=EXACT)


def test_north_is_up():
    rig = orbit(3e7)
    assert np.allclose(rig.camera().basis()[1], local_axes(rig.up)[1], atol=EXACT)


def test_wheel_multiplies_the_height():
    rig = orbit(1e6)
    rig.zoom(1)
    assert rig.height == pytest.approx(1e6 / 1.25)
    rig.zoom(-1)
    assert rig.height == pytest.approx(1e6)


def test_wheel_ends_at_two_metres_and_at_a_hundred_thousand_kilometres():
    rig = orbit(1e6)
    rig.zoom(200)
    assert rig.height == LOWEST == 2.0
    assert height_above_ground(rig.position) == pytest.approx(2.0, abs=1e-3)
    rig.zoom(-400)
    assert rig.height == HIGHEST == 1e8


def test_drag_moves_the_ground_with_the_pointer():
    rig = orbit(2e6, 0.0, 0.0)
    rig.drag(0.1, 0.0)
    assert rig.up[1] < 0.0 and abs(rig.up[2]) < EXACT  # ground to the right: the camera goes west
    rig = orbit(2e6, 0.0, 0.0)
    rig.drag(0.0, 0.1)
    assert rig.up[2] > 0.0 and abs(rig.up[1]) < EXACT  # ground down: the camera goes north


def test_drag_is_gentle_near_the_ground():
    near, far = orbit(10.0), orbit(1e6)
    moved = []
    for rig in (near, far):
        before = rig.up
        rig.drag(0.1, 0.0)
        moved.append(np.linalg.norm(rig.up - before) * R)
    assert moved[0] < 2.0 < moved[1]  # m


def test_a_long_ride_keeps_the_rig_sound(rng):
    rig = orbit()
    for _ in range(500):
        rig.drag(*rng.normal(scale=0.3, size=2))
        rig.look(*rng.normal(scale=0.3, size=2))
        rig.zoom(rng.normal(scale=3))
        assert is_sound(rig)


def test_look_tilts_within_its_range():
    rig = orbit(1e6)
    for dy, angle in ((-100, math.radians(170.0)), (100, 0.0)):
        rig.look(0.0, dy)
        assert rig.angle() == pytest.approx(angle)


# --- flight


@pytest.mark.parametrize(
    "moves, axis", [((1, 0, 0), "ahead"), ((0, 1, 0), "right"), ((0, 0, 1), "up"), ((-1, 0, 0), "back")]
)
def test_flight_goes_where_the_keys_say(moves, axis):
    rig = fly(5e4, 0.0, -30.0)
    ahead, up, before = rig.ahead, rig.up, rig.position
    expected = {"ahead": ahead, "back": -ahead, "right": np.cross(ahead, up), "up": up}[axis]
    rig.advance(0.01, moves)
    step = rig.position - before
    assert step @ expected / np.linalg.norm(step) == pytest.approx(1.0, abs=1e-3)  # the planet curves below


def test_speed_grows_with_the_height_above_the_ground():
    steps = []
    for height in (1e3, 1e5):
        rig = fly(height, 0.0, -30.0)
        before = rig.position
        rig.advance(0.01, (1, 0, 0))
        steps.append(np.linalg.norm(rig.position - before))
    assert steps[1] / steps[0] == pytest.approx(100.0, rel=1e-3)


def test_speed_key():
    slow, fast = fly(1e5, 0.0, -30.0), fly(1e5, 0.0, -30.0)
    start = slow.position
    slow.advance(0.01, (1, 0, 0))
    fast.advance(0.01, (1, 0, 0), 6.0)
    assert np.linalg.norm(fast.position - start) == pytest.approx(6 * np.linalg.norm(slow.position - start), rel=1e-3)


def test_no_flight_into_a_mountain():
    rig = fly(3000.0, 26.0, 86.9)  # in the plain, heading for the Himalaya
    rig.pitch = -0.2
    heights = []
    for _ in range(1000):
        rig.advance(0.05, (1, 0, 0), 600.0)
        heights.append(EARTH.ground.altitude(rig.position))
        assert is_sound(rig)
    assert max(heights) > 1000.0 + heights[0]  # it did climb


def test_flight_around_the_planet_comes_back():
    rig = fly(2e6, 0.0, 0.0)
    rig.ahead = np.array([0.0, 1.0, 0.0])
    start, turned = rig.up, 0.0
    while turned < 2.0 * math.pi:
        before = rig.up
        rig.advance(0.01, (1, 0, 0))
        rig.position *= (R + 2e6) / np.linalg.norm(rig.position)  # straight flight rises from a round planet
        turned += math.asin(min(np.linalg.norm(np.cross(before, rig.up)), 1.0))
    assert rig.up @ start > 0.999  # the last step may go too far by up to 0.01 x 0.8 x 2000 km
    assert abs(rig.up[2]) < EXACT


def test_pitch_stops_before_the_zenith():
    rig = fly()
    rig.drag(0.0, -100.0)
    assert math.radians(88.0) < rig.pitch < math.radians(90.0)
    assert is_sound(rig)


def test_wheel_narrows_the_view_in_flight():
    rig = fly()
    before = rig.fov
    rig.zoom(2)
    assert rig.fov < before
    rig.zoom(-100)
    assert rig.fov == pytest.approx(math.radians(120.0))


@pytest.mark.parametrize("height", [2.0, 500.0, 4e5, 9e6])
def test_change_of_rig_keeps_the_view(height):
    rig = orbit(height)
    rig.look(0.2, -0.3)
    flying = fly_from(rig)
    back = orbit_from(flying)
    for other in (flying, back):
        assert np.allclose(other.position, rig.position, atol=1e-3)  # m
        assert np.allclose(other.camera().basis(), rig.camera().basis(), atol=1e-6)


# --- sun


def test_the_sun_goes_west_and_comes_back_after_a_day():
    sun = SunRig(np.array([1.0, 0.0, 0.0]), 86400.0)
    sun.advance(21600.0)
    assert np.allclose(sun.direction, (0, -1, 0), atol=EXACT)
    sun.advance(64800.0)
    assert np.allclose(sun.direction, (1, 0, 0), atol=EXACT)
    assert sun.elapsed == 86400.0


def test_turning_the_sun():
    position = orbit().position
    sun = SunRig(bearing(position, 1.0, 0.5))
    sun.turn(position, 0.3, -0.2)
    assert azimuth_elevation(position, sun.direction) == pytest.approx((1.3, 0.3))
    sun.turn(position, 0.0, 10.0)
    assert azimuth_elevation(position, sun.direction)[1] == pytest.approx(math.pi / 2, abs=2e-3)
