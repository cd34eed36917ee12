"""Windows of pixels that hold a sphere, against every pixel's ray in float64."""

import dataclasses
import math

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.screen import PIXEL, area, around, frame_around, holds, in_steps, meet, sphere_window
from tests.cameras import R, facing

SIZE = (96, 54)


def pixels_that_meet(camera, size, radius):
    """Return (h, w) bool, row 0 at the bottom: whether each pixel's ray meets a sphere ahead of it."""
    rays, center = camera.pixel_rays(size)[::-1], -np.array(camera.position)
    along = rays @ center
    off = np.linalg.norm(center - along[..., None] * rays, axis=-1)
    return (np.linalg.norm(center) <= radius) | ((off <= radius) & (along > 0.0))


def planet_window(camera, size, radius=R):
    return sphere_window(camera, size, np.negative(camera.position), radius)


def check(camera, size):
    """Return the window that holds every pixel that meets the planet."""
    window, hit = planet_window(camera, size), pixels_that_meet(camera, size, R)
    if not hit.any():
        return window
    rows, columns = np.nonzero(hit.any(1))[0], np.nonzero(hit.any(0))[0]
    seen = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
    assert window is not None and holds(window, seen)
    return window


def random_camera(rng, distance):
    position = rng.normal(size=3)
    position *= distance / np.linalg.norm(position)
    toward = -position / distance + rng.normal(size=3) * rng.choice([0.01, 0.3, 3.0])
    return sa.Camera(position=position, forward=toward, vertical_fov=math.radians(rng.choice([0.5, 20, 60, 120, 175])))


def test_no_pixel_of_a_sphere_is_outside(rng):
    kinds = set()
    for _ in range(400):
        camera = random_camera(rng, R * (1.0 + 10.0 ** rng.uniform(-5, 3)))
        size = [SIZE, (1, 97), (97, 1)][rng.integers(3)]
        window = check(camera, size)
        kinds.add("none" if window is None else "all" if window == (0, 0, *size) else "part")
    assert kinds == {"none", "all", "part"}


def test_windows_are_tight(rng):
    """Whole in view, the sphere touches all four sides within the margin and a pixel of rounding."""
    for _ in range(50):
        camera = dataclasses.replace(facing(rng.normal(size=3), 2e7, 60), target=None, up=tuple(rng.normal(size=3)))
        hit = pixels_that_meet(camera, SIZE, R)
        rows, columns = np.nonzero(hit.any(1))[0], np.nonzero(hit.any(0))[0]
        seen = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
        window = planet_window(camera, SIZE)
        assert np.abs(np.subtract(window, seen)).max() <= PIXEL + 2
        assert not holds(planet_window(camera, SIZE, 0.9 * R), seen)


def test_behind_inside_and_on_the_edge():
    away = sa.Camera(position=(2e7, 0, 0), forward=(1, 0, 0))
    assert planet_window(away, SIZE) is None
    inside = dataclasses.replace(away, position=(0.999 * R, 0, 0))
    assert planet_window(inside, SIZE) == (0, 0, *SIZE)
    # beside the picture: a sphere that a camera looks past by a degree less, and by a degree more
    half = math.degrees(math.asin(R / 2e7))
    for beside, empty in ((-1.0, False), (1.0, True)):
        turn = math.radians(30.0 + half + beside)
        camera = sa.Camera(position=(2e7, 0, 0), forward=(-math.cos(turn), 0, math.sin(turn)), up=(0, 0, 1))
        assert (check(camera, SIZE) is None) == empty
    # wider than the half space ahead: a camera close above the ground that looks along it
    low = sa.Camera(position=(R + 1e3, 0, 0), forward=(0, 1, 0), up=(1, 0, 0), vertical_fov=math.radians(150))
    window = check(low, SIZE)
    assert window[0] == 0 and window[1] == 0 and window[2] == SIZE[0] and window[3] < SIZE[1]


@pytest.mark.parametrize("distance", [3.844e8, 1e9, 1e11])
def test_from_afar(distance):
    fov = math.degrees(2.6 * R / distance)
    window = check(facing((1, 2, 3), distance, fov), SIZE)
    assert 0.2 < area(window) / area((0, 0, *SIZE)) < 0.6
    assert area(check(facing((1, 2, 3), distance, 60), SIZE)) <= 16


def test_windows_among_each_other(rng):
    outer = (8, 0, 24, 16)
    assert holds(outer, (8, 0, 24, 16)) and not holds(outer, (7, 0, 24, 16))
    assert meet(outer, (23, 15, 30, 30)) and not meet(outer, (24, 0, 30, 16))
    assert around(outer, (0, 15, 9, 40)) == (0, 0, 24, 40)
    assert in_steps((9, 7, 17, 50), 8, SIZE) == (8, 0, 24, 54) and area(None) == 0
    for window in (None, (0, 0, *SIZE), (5, 6, 7, 8), (0, 3, 96, 9), (90, 0, 96, 54)):
        covered = np.zeros(SIZE[::-1], int)
        for left, bottom, right, top in [*frame_around(window, SIZE), *([window] if window else [])]:
            covered[bottom:top, left:right] += 1
        assert (covered == 1).all()
