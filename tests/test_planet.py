"""The surface: maps, relief, and the lit ground against the twin's sunlight."""

from dataclasses import replace

import numpy as np
from PIL import Image

import shadowatmo as sa
from shadowatmo.passes.planet import RINGS, SPOKES, polar_grid
from shadowatmo.passes.surface_maps import relief
from tests.cameras import SUN, level

SIZE = (64, 48)


def test_slopes_of_a_known_hill():
    rows, columns, radius = 180, 360, 6.36e6
    longitude = np.radians(np.arange(columns) + 0.5 - 180)
    height = np.broadcast_to(1000 * np.sin(longitude), (rows, columns)).astype(np.float32)
    slopes = relief(height, radius)
    at_equator = slopes[90, :, 0]
    assert np.allclose(at_equator, 1000 * np.cos(longitude) / radius, rtol=1e-2, atol=1e-7)
    assert np.abs(slopes[..., 1]).max() == 0 and np.array_equal(slopes[..., 2], height)
    assert np.array_equal(slopes[..., 3], height <= 0)
    assert abs(at_equator[0] - at_equator[-1]) < 1e-5  # longitudes wrap


def test_polar_grid_covers_the_disc():
    vertices, indices = polar_grid()
    assert len(vertices) == (RINGS + 1) * (SPOKES + 1) and len(indices) == RINGS * SPOKES * 6
    assert vertices.min() == 0 and vertices.max() == 1 and indices.max() == len(vertices) - 1


def test_uniform_ground_is_sunlight_and_skylight(ctx):
    """Straight down from 100 m the pixel holds what the probe finds along its ray, the ground's light included."""
    scene = sa.Scene(suns=SUN, surface=sa.Surface())
    camera = level(40, 100.0, 0, -90)
    with sa.Renderer(ctx, scene, SIZE, "accurate") as renderer:
        pixel = renderer.render(camera).numpy()[24, 32]
    ray = camera.pixel_rays(SIZE)[24, 32]
    truth = sa.probe(ctx, scene, camera.position, ray)
    want = truth.single[0] + truth.multiple[0] + truth.ground_direct[0] + truth.ground_multiple[0]
    assert np.allclose(pixel, want, rtol=1e-2)
    assert np.all(truth.ground_multiple[0] > 0.02 * truth.ground_direct[0])
    with sa.Renderer(ctx, sa.Scene(suns=SUN, surface=None), SIZE, "accurate") as renderer:
        black = renderer.render(camera).numpy()[24, 32]
    assert np.allclose(black, truth.single[0] + truth.multiple[0], rtol=2e-2)


def test_relief_stands_above_the_sphere(ctx):
    """From 9 km above the Himalayas the ground is nearer than the sphere, and the sea elsewhere is not."""
    def depth(latitude, longitude):
        a, b = np.radians(latitude), np.radians(longitude)
        up = np.array([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)])
        scene = sa.Scene(suns=sa.Sun(direction=up), surface=sa.Surface.earth())
        camera = sa.Camera(position=(scene.atmosphere.bottom_radius + 9e3) * up, forward=-up)
        with sa.Renderer(ctx, scene, SIZE, "fast") as renderer:
            return renderer.render(camera).read("depth")[24, 32, 0]

    assert 2500 < depth(33.0, 86.0) < 5500  # the plateau of Tibet, about 5 km high
    assert abs(depth(0.0, -150.0) - 9e3) < 20


def test_an_islet_darkens_the_sea_no_farther_than_it_reaches(ctx, tmp_path):
    """Ground that reflects nothing shows the mirror alone: gone on a cell of land, whole a cell and a half away."""
    levels = np.zeros((2, 90, 180), np.uint8)  # cells of two degrees
    levels[1, 45, 90] = 128
    radiance = []
    for number, image in enumerate(levels):
        path = tmp_path / f"{number}.png"
        Image.fromarray(image).save(path)
        scene = sa.Scene(
            atmosphere=replace(sa.EARTH, ground_albedo=(0, 0, 0)),
            suns=sa.Sun(direction=(1, 0, 0)),
            surface=sa.Surface(height=path, sea=True),
        )
        camera = sa.Camera(position=(2e7, 0, 0), target=(0, 0, 0), vertical_fov=np.radians(10))
        with sa.Renderer(ctx, scene, (161, 161), sa.Quality(orders=1, depth="analytic")) as renderer:
            radiance.append(renderer.render(camera).numpy()[..., 0].astype(float))
    sea, islet = radiance
    # a pixel is 0.13 degrees of longitude here; the cell's middle lies a degree east and south of the axis
    lost = 1.0 - islet / sea
    assert lost[88, 88] > 0.5 * lost.max() > 0.05
    # the smoothed altitude still lifts the air there a little
    assert np.abs(lost[88, [88 - 20, 88 + 20]]).max() < 0.01 and np.abs(lost[[88 - 20, 88 + 20], 88]).max() < 0.01


def test_date_line_has_no_seam(ctx):
    """A strip of sea across 180 degrees of longitude varies smoothly."""
    up = np.array([-1.0, 0.0, 0.0])
    scene = sa.Scene(suns=sa.Sun(direction=up), surface=sa.Surface.earth())
    camera = sa.Camera(position=1.5e7 * up, target=(0, 0, 0), vertical_fov=0.3)
    with sa.Renderer(ctx, scene, (201, 41)) as renderer:
        row = renderer.render(camera).numpy()[10].astype(float)
    steps = np.abs(np.diff(row, axis=0)).max(axis=1)
    assert steps[95:106].max() <= 1.5 * steps.max() and steps[95:106].max() < 0.02


def test_night_is_dark(ctx):
    scene = sa.Scene(suns=SUN, surface=sa.Surface.earth())
    with sa.Renderer(ctx, scene, SIZE) as renderer:
        day = renderer.render(level(50, 1e4, 0, -60)).numpy()
        night = renderer.render(level(125, 1e4, 0, -60)).numpy()
    assert day.min() > 1e-4 and night.max() < 1e-6 * day.max()

