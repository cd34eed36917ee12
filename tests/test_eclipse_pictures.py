"""The set "eclipses": shadows lie where they must, rings are closed, and the skies are those of the ephemeris."""

import numpy as np
import pytest

from shadowatmo.ephemeris import sun_center
from shadowatmo.gallery import pictures, select
from shadowatmo.gallery_eclipses import EARTH, GANYMEDE, IO, JUPITER, SKIES, sky
from shadowatmo.observing import observed
from shadowatmo.places import local_axes

SIZE = (161, 91)
NAMES = [picture.name for picture in pictures("eclipses")]


@pytest.fixture(scope="module")
def drawn(ctx):
    """Radiance (h, w, 3) and picture (h, w, 3) of every picture; the fisheye has the picture alone."""
    from shadowatmo.passes.gallery import Gallery

    found = {}
    with Gallery(ctx, SIZE, "fast") as gallery:
        for picture in pictures("eclipses"):
            image = np.asarray(gallery.draw(picture))
            found[picture.name] = (gallery._frame(picture, picture.quality).numpy(), image)
    return found


def pixel(picture, point):
    """Return row and column at which a camera sees a point (3,) [m]."""
    right, up, forward = picture.camera.basis() @ (np.asarray(point) - picture.camera.position)
    tan_x, tan_y = picture.camera.tangents(SIZE)
    column = 0.5 * SIZE[0] * (1.0 + right / forward / tan_x)
    return int(0.5 * SIZE[1] * (1.0 - up / forward / tan_y)), int(column)


def spot(drawn, name, point):
    """Return the least radiance within a pixel of a point, and the median of the whole picture's lit ones."""
    radiance = drawn[name][0].sum(axis=2)
    row, column = pixel(select([name])[0], point)
    return radiance[row - 1 : row + 2, column - 1 : column + 2].min(), np.median(radiance[radiance > 0])


@pytest.mark.parametrize("name", SKIES)
def test_the_skies_are_those_of_the_ephemeris(name):
    date, observer, sun, moon, position = SKIES[name]
    found = observed(EARTH, date, observer)
    assert np.abs(np.subtract(sun_center(found.sun), sun)).max() < 1e3  # m of 1.5e11: digits of the table
    assert np.abs(np.subtract(found.moon.center, moon)).max() < 1.0
    assert np.abs(np.subtract(found.position, position)).max() < 1.0
    assert sky(name).toward_sun() == pytest.approx(found.toward_sun(), abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_every_picture_is_finite_and_not_black(drawn, name):
    radiance, image = drawn[name]
    assert np.isfinite(radiance).all() and image.shape == (SIZE[1], SIZE[0], 3)
    assert image.max() > 120 and len(np.unique(image.reshape(-1, 3), axis=0)) > 20
    assert (image.min(axis=2) > 250).mean() < 0.2


@pytest.mark.parametrize("name, place", [("shadow_from_moon", "kentucky"), ("shadow_from_400km", "madras")])
def test_the_moons_shadow_lies_over_the_observer(drawn, name, place):
    dark, usual = spot(drawn, name, SKIES[place][4])
    assert dark < 0.1 * usual
    north = local_axes(SKIES[place][4])[1]
    elsewhere, _ = spot(drawn, name, np.array(SKIES[place][4]) + 6e5 * north)
    assert elsewhere > 3.0 * dark


def test_three_shadows_on_the_large_planet(drawn):
    """Each is dark where its moon's line to the sun meets the clouds; the penumbra is wider the farther the moon."""
    for moon in select(["jupiter_shadows"])[0].scene.occluders:
        _, y, z = moon.center
        x = np.sqrt(JUPITER.bottom_radius**2 - y**2 - z**2)
        dark, usual = spot(drawn, "jupiter_shadows", (x, y, z))
        assert dark < 0.3 * usual  # a pixel at the edge of the smallest may be lit by half
    assert GANYMEDE[0] > 2.0 * IO[0]


def test_the_ring_is_closed_and_dark_inside(drawn):
    light = drawn["annular_ring"][0].sum(axis=2)
    y, x = np.indices(light.shape) + 0.5
    angle = np.arctan2(y - SIZE[1] / 2, x - SIZE[0] / 2)
    sector = np.floor((angle + np.pi) / (2 * np.pi) * 12).astype(int).clip(0, 11)
    ring = np.array([light[sector == n].max() for n in range(12)])
    assert ring.min() > 0.3 * ring.max()
    assert light[40:51, 75:86].max() < 1e-3 * ring.min()


def test_totality_is_dark_overhead_and_bright_all_around(drawn):
    image = drawn["totality_fisheye"][1].astype(float).sum(axis=2)
    y, x = np.indices(image.shape) + 0.5
    r = np.hypot(y - SIZE[1] / 2, x - SIZE[0] / 2) / (SIZE[1] / 2)
    horizon, zenith = image[(r > 0.88) & (r < 0.93)], image[r < 0.4]
    assert zenith.max() < 0.5 * np.median(horizon)
    assert image[r > 1.02].max() < 5
    for name in ("north", "east", "south", "west"):
        radiance = drawn[f"totality_{name}"][0].sum(axis=2)
        assert radiance[:10].max() < 0.3 * radiance.max()


def test_the_shadow_of_one_sun_is_lit_by_the_other(drawn):
    """Where the blue sun is hidden the ground is redder than anywhere beside it, and where the orange one is, bluer."""
    picture = select(["two_suns_shadows"])[0]
    radiance, spots = drawn["two_suns_shadows"][0], []
    for sun in picture.scene.suns:
        toward, center = np.array(sun.direction), np.array(picture.scene.occluders[0].center)
        along = center @ toward
        t = along - np.sqrt(along**2 - center @ center + EARTH.radius**2)
        row, column = pixel(picture, center - t * toward)
        spots.append((row, column))
    between = tuple(np.sum(spots, axis=0) // 2)
    without_blue, without_orange, with_both = (radiance[at][0] / radiance[at][2] for at in (*spots, between))
    assert without_blue > 2.0 * with_both > 2.2 * without_orange


def test_compensation_is_a_factor_on_the_automatic_exposure(drawn):
    from dataclasses import replace

    from shadowatmo.passes.gallery import _exposure

    picture = select(["totality_north"])[0]
    radiance = drawn["totality_north"][0]
    half = _exposure(replace(picture, compensation=0.5 * picture.compensation), radiance)
    assert half == pytest.approx(0.5 * _exposure(picture, radiance))
    assert _exposure(replace(picture, exposure=3.0), radiance) == 3.0
