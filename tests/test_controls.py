"""Keys and pointer: every key of the help does what it says."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from shadowatmo.camera import Camera
from shadowatmo.controls import KEYS, Controls, distance, key_names
from shadowatmo.errors import ParameterError
from shadowatmo.places import azimuth_elevation
from shadowatmo.quality import METHODS
from shadowatmo.rigs import FlyRig, OrbitRig
from shadowatmo.scene import Scene
from shadowatmo.worlds import WORLDS


def tap(controls, *keys):
    for key in keys:
        controls.press(key)
        controls.release(key)


def test_every_key_is_taken_at_every_moment():
    controls = Controls()
    for key in KEYS * 2:
        controls.press(key)
        controls.advance(0.02)
        assert isinstance(controls.camera(), Camera) and isinstance(controls.scene(), Scene)
        assert controls.status()
        controls.release(key)
    assert not controls.held


def test_unknown_keys_do_nothing():
    controls = Controls()
    before = controls.status()
    tap(controls, "f7", "undefined")
    controls.advance(0.1)
    assert controls.status() == before


def test_tab_changes_the_rig_and_keeps_the_place():
    controls = Controls()
    before = controls.rig.position
    assert isinstance(controls.rig, OrbitRig)
    tap(controls, "tab")
    assert isinstance(controls.rig, FlyRig)
    assert np.allclose(controls.rig.position, before)
    tap(controls, "tab")
    assert isinstance(controls.rig, OrbitRig)


@pytest.mark.parametrize("rig", ["orbit", "fly"])
@pytest.mark.parametrize("key", "wasdqe")
def test_movement_keys_move(rig, key):
    controls = Controls()
    if rig == "fly":
        tap(controls, "tab")
    before = controls.rig.position
    controls.press(key)
    controls.advance(0.1)
    assert np.linalg.norm(controls.rig.position - before) > 1e4
    controls.release(key)
    before = controls.rig.position
    controls.advance(0.1)
    assert np.array_equal(controls.rig.position, before)


def test_shift_and_ctrl_change_the_speed():
    moved = {}
    for held in ("", "shift", "ctrl"):
        controls = Controls()
        tap(controls, "tab")
        controls.press(held)
        controls.press("d")
        before = controls.rig.position
        controls.advance(0.01)
        moved[held] = np.linalg.norm(controls.rig.position - before)
    assert moved["ctrl"] < moved[""] / 5 and moved["shift"] > moved[""] * 5


def test_a_stall_does_not_jump():
    controls = Controls()
    tap(controls, "space")
    controls.advance(3600.0)
    assert controls.sun.elapsed == pytest.approx(0.25 * controls.clock)


def test_arrows_move_the_sun():
    controls = Controls()
    place = controls.rig.position
    before = azimuth_elevation(place, controls.sun.direction)
    controls.press("up")
    controls.press("right")
    controls.advance(0.1)
    after = azimuth_elevation(place, controls.sun.direction)
    assert np.subtract(after, before) == pytest.approx((math.radians(2.0), math.radians(2.0)))


def test_clock_keys():
    controls = Controls()
    before = controls.sun.direction
    controls.advance(0.1)
    assert np.array_equal(controls.sun.direction, before)  # stopped at first
    tap(controls, "space", "period")
    controls.advance(0.1)
    assert controls.sun.elapsed == pytest.approx(0.1 * 1200.0)
    tap(controls, "comma", "comma")
    assert controls.clock == 300.0


def test_quality_keys_go_round():
    controls = Controls()
    seen = []
    for _ in range(3):
        tap(controls, "n")
        seen.append((controls.quality.depth, controls.quality.depth_bits))
    assert seen == [("textures", 32), ("textures", 24), ("analytic", 32)]
    tap(controls, "k")
    assert controls.quality.shadow == "cone"
    tap(controls, "k")
    assert controls.quality.shadow == "cylinder"
    methods = []
    for _ in METHODS:
        tap(controls, "m")
        methods.append(controls.quality.method)
    assert sorted(methods) == sorted(METHODS) and methods[-1] == "segments"  # each once, and back where it began


def test_automatic_exposure_is_taken_at_once_and_then_followed_slowly():
    controls = Controls()
    controls.adapt(20.0, 0.1)
    assert controls.exposure == pytest.approx(20.0)
    controls.adapt(80.0, 0.5)  # after one time constant 63 % of the way, counted in stops
    assert math.log2(controls.exposure / 20.0) == pytest.approx(2.0 * (1.0 - math.exp(-1.0)))


def test_exposure_keys_end_the_automatic_one():
    controls = Controls()
    controls.adapt(10.0, 0.1)
    tap(controls, "right_bracket")
    assert controls.exposure == pytest.approx(10.0 * 2**0.25) and not controls.automatic
    controls.adapt(99.0, 10.0)
    assert controls.exposure == pytest.approx(10.0 * 2**0.25)
    tap(controls, "x")
    assert controls.automatic


def test_planet_and_start_keys():
    controls = Controls()
    controls.wheel(5)
    tap(controls, "p")
    assert controls.scene_name == "mars" and "mars" in controls.status()
    controls.wheel(5)
    tap(controls, "r")
    assert controls.rig.height == pytest.approx(controls.world.far_height)


@pytest.mark.parametrize("name", WORLDS)
def test_every_planet_is_whole_in_its_first_view(name):
    controls = Controls(name)
    camera, radius = controls.camera(), controls.world.radius
    position = np.array(camera.position)
    away = np.linalg.norm(position)
    assert np.dot(camera.forward, position) / away == pytest.approx(-1.0)  # its center is in the middle
    size = math.asin(radius / away) / (camera.vertical_fov / 2.0)
    assert 0.6 < size < 1.0  # it fills the picture's height, but not more
    assert np.dot(controls.sun.direction, position) > 0.0  # by day


def test_the_planet_key_shows_all_of_them():
    controls, seen = Controls(), []
    for _ in WORLDS:
        tap(controls, "p")
        seen.append(controls.scene_name)
    assert sorted(seen) == sorted(WORLDS) and seen[-1] == "earth"


def test_wishes():
    controls = Controls()
    tap(controls, "f1", "f12", "escape")
    assert (controls.wants_help, controls.wants_picture, controls.wants_quit) == (False, True, True)


def test_lost_keyboard_stops_movement():
    controls = Controls()
    controls.press("w")
    controls.release_all()
    before = controls.rig.position
    controls.advance(0.1)
    assert np.array_equal(controls.rig.position, before)


def test_an_unknown_scene_is_refused():
    with pytest.raises(ParameterError, match="scene"):
        Controls("pluto")


@pytest.mark.parametrize("metres, text", [(2, "2.0 m"), (345, "345 m"), (12345, "12.3 km"), (1.35e7, "13 500 km")])
def test_distance(metres, text):
    assert distance(metres) == text


def test_key_codes_of_a_backend():
    codes = {"W": 119, "LEFT_SHIFT": 1, "RIGHT_SHIFT": 2, "LEFT_CTRL": 3, "TAB": 9, "LEFT": 10, "Q": "undefined"}
    names = {119: "w", 1: "shift", 2: "shift", 3: "ctrl", 9: "tab", 10: "left"}
    assert key_names(SimpleNamespace(**codes)) == names


def test_an_unknown_quality_is_refused():
    with pytest.raises(ParameterError, match="quality"):
        Controls(quality="best")
