"""Places and directions against what a globe says."""

import math

import numpy as np
import pytest

from shadowatmo.errors import ParameterError
from shadowatmo.places import Ground, azimuth_elevation, bearing, local_axes, place, rotate
from shadowatmo.surface import Surface
from shadowatmo.worlds import WORLDS, world

R = 6.36e6
EXACT = 1e-12  # a few roundings of float64


@pytest.mark.parametrize(
    "latitude, longitude, axis", [(0, 0, (1, 0, 0)), (0, 90, (0, 1, 0)), (90, 12, (0, 0, 1)), (0, -90, (0, -1, 0))]
)
def test_place(latitude, longitude, axis):
    point = place(R, math.radians(latitude), math.radians(longitude), 1000.0)
    assert np.allclose(point, np.multiply(axis, R + 1000.0), atol=EXACT * R)


def test_a_latitude_beyond_the_pole_is_refused():
    with pytest.raises(ParameterError, match="latitude"):
        place(R, 1.6, 0.0)


@pytest.mark.parametrize("point", [(R, 0, 0), (0.3, -2.0, 1.1), (0, 0, 5.0), (0, 0, -5.0)])
def test_local_axes_are_a_rotation_with_up_outward(point):
    axes = local_axes(point)
    assert np.allclose(axes @ axes.T, np.eye(3), atol=EXACT)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert np.allclose(axes[2], np.array(point) / np.linalg.norm(point))


def test_the_center_has_no_local_axes():
    with pytest.raises(ParameterError, match="center"):
        local_axes((0.0, 0.0, 0.0))


def test_bearings_of_the_compass():
    equator = (R, 0.0, 0.0)
    assert np.allclose(bearing(equator, 0.0, 0.0), (0, 0, 1), atol=EXACT)  # north
    assert np.allclose(bearing(equator, math.pi / 2, 0.0), (0, 1, 0), atol=EXACT)  # east
    assert np.allclose(bearing(equator, 1.0, math.pi / 2), (1, 0, 0), atol=EXACT)  # zenith


def test_azimuth_and_elevation_undo_bearing(rng):
    for _ in range(50):
        point, azimuth, elevation = rng.normal(size=3), rng.uniform(0, 2 * math.pi), rng.uniform(-1.5, 1.5)
        found = azimuth_elevation(point, 7.0 * bearing(point, azimuth, elevation))
        assert found == pytest.approx((azimuth, elevation), abs=1e-10)  # acos-free, so near the rounding


def test_rotate_is_right_handed():
    assert np.allclose(rotate((1, 0, 0), (0, 0, 1), math.pi / 2), (0, 1, 0), atol=EXACT)


def test_ground_is_flat_without_a_map():
    assert Ground(None).altitude((R, 0, 0)) == Ground(Surface()).altitude((0, 0, R)) == 0.0


@pytest.mark.parametrize(
    "latitude, longitude, low, high",
    [(33, 88, 4500, 5500), (0, -30, 0, 0), (-80, 77, 3700, 4200), (72, -38, 2900, 3300), (90, 0, 0, 300)],
    ids=["Tibet", "Atlantic", "Dome A", "Greenland", "north pole"],
)
def test_ground_of_the_earth(latitude, longitude, low, high):
    point = place(R, math.radians(latitude), math.radians(longitude))
    assert low <= world("earth").ground.altitude(point) <= high


def test_ground_has_no_step_at_the_date_line():
    ground = world("earth").ground
    west, east = (ground.altitude(place(R, 1.15, sign * (math.pi - 1e-9))) for sign in (1, -1))
    assert west == pytest.approx(east, abs=1e-2)  # m; 1e-9 rad are 6 mm of ground


def test_ground_is_smooth():
    ground = world("earth").ground
    longitudes = np.radians(np.linspace(86.0, 86.5, 400))  # steps of 120 m across the cells of the map
    heights = np.array([ground.altitude(place(R, math.radians(28.0), lon)) for lon in longitudes])
    assert np.ptp(heights) > 100.0  # there is relief to be smooth
    assert np.abs(np.diff(heights, 2)).max() < 0.5  # m; a kink of a bilinear map between 25 m levels makes several


def test_an_unknown_world_is_refused():
    with pytest.raises(ParameterError, match="'earth', 'mars'"):
        world("venus")


@pytest.mark.parametrize("name", WORLDS)
def test_worlds_make_scenes(name):
    scene = WORLDS[name].scene((0, 1, 0))
    assert scene.atmosphere is WORLDS[name].atmosphere
    assert scene.sun_disc and scene.surface is not None
