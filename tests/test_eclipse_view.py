"""Multiple scattering under moons in frames: the camera's coarse table of ratios against rays."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.eclipse_view import air_rectangle
from shadowatmo.passes.view import View
from shadowatmo.quality import Quality, as_quality
from tests.cameras import SUN, facing, level
from tests.test_eclipse_multiple import eclipse

SIZE = (160, 90)


def pixel_rays(camera, pixels):
    """Return the directions (N, 3) of pixels (N, 2), row 0 at the top."""
    right, up, forward = camera.basis()
    tan_x, tan_y = camera.tangents(SIZE)
    x, y = (2.0 * (pixels + 0.5) / SIZE - 1.0).T
    rays = forward + np.outer(tan_x * x, right) - np.outer(tan_y * y, up)
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def multiple_light(ctx, scene, camera, quality):
    """Return what multiple scattering adds to a frame, (h, w, 3)."""
    frames = []
    for orders in ("all", 1):
        with sa.Renderer(ctx, scene, SIZE, dataclasses.replace(as_quality(quality), orders=orders)) as renderer:
            frames.append(renderer.render(camera).numpy().astype(np.float64))
    return frames[0] - frames[1]


@pytest.mark.parametrize(
    ("camera", "median", "p95"),
    [
        (level(45, 2.0, 90, 15), 0.02, 0.06),  # in totality
        (level(50, 1e4, 180, -4), 0.03, 0.12),  # outside, the umbra ahead
        (level(48, 4e5, 180, -60), 0.01, 0.06),  # above it
        (facing((0.8, 0.6, 0.1), 3.8e8, 2.2), 0.01, 0.05),  # from the Moon's distance
    ],
)
def test_frames_agree_with_rays(ctx, rng, camera, median, p95):
    """The ratio to the frame without a moon: that frame's own error is judged elsewhere."""
    scene, plain = eclipse(45.0)[0], sa.Scene(suns=SUN)
    pixels = np.stack([rng.integers(0, n, 300) for n in SIZE], axis=1)
    light = [multiple_light(ctx, s, camera, "balanced")[pixels[:, 1], pixels[:, 0]] for s in (scene, plain)]
    origins, directions = np.tile(camera.position, (300, 1)), pixel_rays(camera, pixels)
    rays = [sa.probe(ctx, s, origins, directions, quality="balanced").multiple for s in (scene, plain)]
    lit = rays[1].min(axis=1) > 1e-6
    got, want = ((a[lit] / b[lit]) for a, b in (light, rays))
    error = np.abs(got / want - 1.0)
    # cells of 40 pixels at 1280 x 720 whatever the frame's size
    assert lit.sum() > 50 and np.median(error) < median and np.percentile(error, 95) < p95
    assert want.min() < 0.5


def test_frames_from_afar_are_alike(ctx):
    """A picture 40 km high of the umbra's edge: from 1e11 m, where a float's step is 8 km, as from 1e9 m."""
    scene = eclipse(45.0)[0]
    spot = np.array([np.cos(np.radians(45.0)), np.sin(np.radians(45.0)), 0.0])
    target = sa.EARTH.bottom_radius * spot + np.array([0.0, 0.0, 6e4])
    toward = 0.9 * spot + np.array([0.1, -0.3, 0.2])
    toward /= np.linalg.norm(toward)
    frames = []
    for distance in (1e9, 1e11):
        camera = sa.Camera(
            position=target + distance * toward, target=target, vertical_fov=2.0 * np.arctan(2e4 / distance)
        )
        frames.append(multiple_light(ctx, scene, camera, "balanced"))
    # 16-bit floats of the table and of the frame; told by its distance from the camera the edge moves by 3 %
    assert np.max(np.abs(frames[1] / frames[0] - 1.0)) < 4e-3
    assert np.ptp(frames[0]) > 0.3 * frames[0].max()


def test_a_frame_outside_the_shadow_is_as_without(ctx):
    camera = level(45, 2.0, 90, 15)
    far = sa.Occluder(center=(3.66e8, -9.6e6, 0.0), radius=1.7374e6)
    scenes = sa.Scene(suns=SUN, occluders=far), sa.Scene(suns=SUN)
    shaded, plain = (multiple_light(ctx, s, camera, "balanced") for s in scenes)
    with sa.Renderer(ctx, scenes[0], SIZE) as renderer:
        assert "eclipse_view" in renderer.plan and "eclipse_multiple" in renderer.plan
    with sa.Renderer(ctx, scenes[1], SIZE) as renderer:
        assert "eclipse_view" not in renderer.plan and "eclipse_multiple" not in renderer.plan
    # within a step of 8 bits, with room to spare
    assert np.max(np.abs(shaded - plain)) < 1e-4 * plain.max()


def test_ground_is_as_dark_as_rays_say(ctx):
    """What a gray ground adds to the frame in totality and beside it, seen from 10 km, against the probe."""
    scene, _ = eclipse(45.0)
    for zenith in (45.0, 43.5):
        camera, frames = level(zenith, 1e4, 0, -89), []
        for surface in (sa.Surface(), None):
            with sa.Renderer(ctx, dataclasses.replace(scene, surface=surface), SIZE) as renderer:
                frames.append(renderer.render(camera).numpy()[45, 80].astype(np.float64))
        ray = sa.probe(ctx, scene, [camera.position], pixel_rays(camera, np.array([[80, 45]])), quality="balanced")
        assert ray.ground_multiple[0, 2] > 0.05 * ray.ground_direct[0, 2]
        assert np.allclose(frames[0] - frames[1], (ray.ground_direct + ray.ground_multiple)[0], rtol=2e-3)


def test_rectangle_holds_the_air():
    view = View(sa.Scene(suns=SUN), Quality(), facing((0.8, 0.6, 0.1), 3.8e8, 20.0), SIZE)
    low, high = air_rectangle(view)
    radius = SIZE[1] * (sa.EARTH.top_radius / 3.8e8) / (2.0 * np.tan(np.radians(10.0)))
    assert np.allclose(0.5 * (low + high), (80, 45)) and np.allclose(high - low, 2.04 * radius, rtol=0.01)
    for camera in (level(45, 2.0, 90, 15), level(45, 4e5, 0, -20), facing((1, 0, 0), 1e7, 60)):
        corners = air_rectangle(dataclasses.replace(view, camera=camera))
        assert np.all(corners[0] >= 0.0) and np.all(corners[1] <= SIZE) and np.all(corners[1] > corners[0])
    away = sa.Camera(position=(3.8e8, 0, 0), forward=(1.0, 0, 0), vertical_fov=0.5)
    assert np.array_equal(air_rectangle(dataclasses.replace(view, camera=away)), [(0, 0), SIZE])
