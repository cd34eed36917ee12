"""Tables under moons: what a mean visible fraction makes of light that a table holds without them."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from tests.cameras import SUN, above, level

NOON = np.array([1.0, 0.0, 0.0])
MOON = sa.Occluder(center=3.66e8 * NOON, radius=1.7374e6)  # its umbra is about 50 km wide on the ground
BARE = sa.Scene(suns=SUN)
SHADED = dataclasses.replace(BARE, occluders=MOON)
SIZE = (40, 22)


def rays(count, rng):
    """Return origins near the ground in and about the shadow, and directions above the horizon, (n, 3)."""
    aside = rng.uniform(0.0, 2.5e6, count) / sa.EARTH.bottom_radius
    around = rng.uniform(0.0, 2.0 * np.pi, count)
    up = np.column_stack([np.cos(aside), np.sin(aside) * np.cos(around), np.sin(aside) * np.sin(around)])
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    directions *= np.where((directions * up).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    return (sa.EARTH.bottom_radius + 100.0) * up, directions


@pytest.mark.parametrize("method", ["table3d", "table3d-multiple", "table4d"])
def test_the_moon_takes_about_its_part(ctx, rng, method):
    quality = sa.Quality(method=method, orders=1)
    origins, directions = rays(200, rng)
    bare, shaded = (sa.probe(ctx, scene, origins, directions, quality=quality).single for scene in (BARE, SHADED))
    truth = [reference.probe(scene, origins, directions).single for scene in (BARE, SHADED)]
    part, want = shaded / bare, truth[1] / truth[0]
    # one fraction for three colors, weighted as green is, at 24 uniform steps, of which grazing rays have few in the
    # penumbra's steep part; measured: 1.3e-4, 2.8e-3, 1.3e-2
    error = np.abs(part - want)
    assert np.median(error) < 3e-4 and np.percentile(error, 95) < 5e-3 and error.max() < 0.025
    assert np.percentile(np.abs(1.0 - want), 95) > 0.5  # what leaving the moon out would be


def test_frames_know_the_moon_and_scenes_without_pay_nothing(ctx):
    camera = level(0.0, 100.0, 0.0, 40.0)
    quality = sa.Quality(method="table4d", depth="analytic")
    pictures = {}
    for name, scene in (("bare", BARE), ("shaded", SHADED)):
        with sa.Renderer(ctx, scene, SIZE, quality) as renderer:
            pictures[name] = renderer.render(camera).numpy()
    directions = camera.pixel_rays(SIZE).reshape(-1, 3)
    origins = np.broadcast_to(above(0.0, 100.0), directions.shape)
    single = [sa.probe(ctx, s, origins, directions, quality=quality).single for s in (BARE, SHADED)]
    part = pictures["shaded"].reshape(-1, 3) / pictures["bare"].reshape(-1, 3)
    # the same steps in both; a pixel's float32 ray and a probe's float64 one
    assert np.abs(part - single[1] / single[0]).max() < 1e-3
    assert part.min() < 0.2 and not np.array_equal(pictures["bare"], pictures["shaded"])
