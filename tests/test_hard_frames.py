"""Whole frames of hard cameras: from under the ground to 1e11 m, slits of 1:4096, fields of view of 0.01 and 175."""

from dataclasses import replace

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from tests.hard_cases import QUALITY, SUNS, direction
from tests.test_hard_cameras import ALTITUDES

E = sa.EARTH
R = E.bottom_radius
ANALYTIC = replace(QUALITY, depth="analytic")
TEXTURES = replace(QUALITY, depth="textures")
EVERY = sa.Quality(depth="analytic")
# Relative, of light down to 1e-3 of the frame's brightest: sunlight grazing the ozone, as for single rays, and at the
# top's limb float32 tells a ray's tangent height to 0.1 m of the last meters of air.
LIGHT = 2.5e-3
SIZES = {"4096:1": (4096, 1), "1:4096": (1, 4096)}


def horizon_camera(altitude, fov, air=E):
    """Look at the horizon, or from afar at the planet's middle."""
    radius = air.bottom_radius + altitude
    dip = -np.arccos(min(air.bottom_radius / radius, 1.0))
    return sa.Camera(
        position=(radius, 0.0, 0.0), forward=direction(dip, 0.7), up=(1.0, 0.1, 0.2), vertical_fov=np.radians(fov)
    )


def planet_camera(altitude, share=1.2, air=E):
    """Look at the planet's center; the picture's height is `share` of the air's diameter."""
    radius = air.bottom_radius + altitude
    angle = 2.0 * np.arctan(share * air.top_radius / radius)
    return sa.Camera(position=(radius, 0.0, 0.0), target=(0.0, 0.0, 0.0), up=(0.1, 0.2, 1.0), vertical_fov=angle)


def usual_camera(altitude):
    return horizon_camera(altitude, 60.0) if altitude < 1e6 else planet_camera(altitude)


def drawn(ctx, camera, size, quality, sun=SUNS["80 degrees"], air=E):
    """Return light (N, 3), lit width (N,) and shadowed width (N,) of a frame's pixels, float64."""
    with sa.Renderer(ctx, sa.Scene(air, sa.Sun(sun)), size, quality) as renderer:
        frame = renderer.render(camera)
        light, *widths = (frame.read(name).astype(np.float64) for name in ("color", "lit_width", "shadow_width"))
    return light[..., :3].reshape(-1, 3), *(width.ravel() for width in widths)


def twin(camera, size, sun=SUNS["80 degrees"], air=E):
    rays = camera.pixel_rays(size).reshape(-1, 3)
    return reference.probe(sa.Scene(air, sa.Sun(sun)), np.tile(camera.position, (len(rays), 1)), rays)


def light_error(light, truth):
    assert np.isfinite(light).all() and (light >= 0.0).all()
    return (np.abs(light - truth.single) / np.maximum(truth.single, max(1e-3 * truth.single.max(), 1e-30))).max(axis=1)


@pytest.mark.parametrize("place", ALTITUDES)
def test_frames_from_everywhere(ctx, place):
    camera, size = usual_camera(ALTITUDES[place]), (24, 16)
    truth = twin(camera, size)
    for quality in (ANALYTIC, TEXTURES):
        light, lit, shadow = drawn(ctx, camera, size, quality)
        error = light_error(light, truth)
        assert error.max() < LIGHT, error.max()
        # float32 near the planet, and from afar as well: nothing is told by its distance from the camera. Distances
        # from depth textures have the digits of the camera's distance, as long as those are good enough.
        coarse = 2e-7 * ALTITUDES[place] if quality is TEXTURES and ALTITUDES[place] < 5e8 else 0.0
        for found, wanted in ((lit, truth.lit), (shadow, truth.shadow)):
            assert np.percentile(np.abs(found - wanted), 95) < 0.5 + coarse
            # rays that graze the ground or the shadow's edge turn 0.3 m into 15
            assert np.max(np.abs(found - wanted)) < 20.0 + 3.0 * coarse


@pytest.mark.parametrize("fov", [0.01, 175.0])
@pytest.mark.parametrize("altitude", [2.0, 4e5, 3.6e7, 1e9])
def test_fields_of_view(ctx, altitude, fov):
    camera, size = horizon_camera(altitude, fov), (24, 16)
    light, lit, _ = drawn(ctx, camera, size, ANALYTIC)
    truth = twin(camera, size)
    # from 1e9 m a pixel of 1e-5 radians is 10 km wide; float32's last digits of its place are a meter
    assert light_error(light, truth).max() < 2.0 * LIGHT
    # all of a narrow picture's rays graze the ground, which turns 0.1 m into 10
    assert np.percentile(np.abs(lit - truth.lit), 50) < 10.0
    # and the picture is one: the rays are those of the definition, not one and the same
    if altitude < 1e6:
        assert len(np.unique(np.round(light[:, 2], 9))) > 20


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("altitude", [2.0, 4e5, 3.6e7])
def test_slits(ctx, altitude, shape):
    size = SIZES[shape]
    # one pixel wide: 60 degrees high; one pixel high: a hundredth of that, for a picture 4096 times as wide
    camera = horizon_camera(altitude, 60.0 if size[0] == 1 else 0.1)
    light, lit, _ = drawn(ctx, camera, size, ANALYTIC)
    some = np.random.default_rng(2).choice(4096, 500, replace=False)
    rays = camera.pixel_rays(size).reshape(-1, 3)[some]
    scene = sa.Scene(E, sa.Sun(SUNS["80 degrees"]))
    truth = reference.probe(scene, np.tile(camera.position, (500, 1)), rays)
    assert np.isfinite(light).all() and (light >= 0.0).all()
    assert light_error(light[some], truth).max() < LIGHT
    assert np.percentile(np.abs(lit[some] - truth.lit), 95) < 2.0


HARD_VIEWS = {
    "0.01 degrees, 2 m": (horizon_camera(2.0, 0.01), (24, 16)),
    "175 degrees, 2 m": (horizon_camera(2.0, 175.0), (24, 16)),
    "175 degrees, 400 km": (horizon_camera(4e5, 175.0), (24, 16)),
    "a slit across, 400 km": (horizon_camera(4e5, 0.1), SIZES["4096:1"]),
    "a slit upright, 2 m": (horizon_camera(2.0, 60.0), SIZES["1:4096"]),
    "1e9 m": (planet_camera(1e9), (24, 16)),
    "1e11 m": (planet_camera(1e11), (24, 16)),
}


@pytest.mark.parametrize("view", HARD_VIEWS)
def test_frames_that_turn_a_little(ctx, view):
    """A millionth of the picture's height aside: the change is the twin's, but for float32's last digits."""
    camera, size = HARD_VIEWS[view]
    right, *_ = camera.basis()
    angle = 1e-6 * camera.vertical_fov
    aside = replace(camera, target=None, forward=np.array(camera.basis()[2]) + angle * right)
    some = np.random.default_rng(3).choice(size[0] * size[1], 384, replace=False)
    found, wanted, ends = [], [], []
    for c in (camera, aside):
        found.append(drawn(ctx, c, size, ANALYTIC)[0][some])
        rays = c.pixel_rays(size).reshape(-1, 3)[some]
        scene = sa.Scene(E, sa.Sun(SUNS["80 degrees"]))
        truth = reference.probe(scene, np.tile(c.position, (len(rays), 1)), rays)
        wanted.append(truth.single)
        ends.append(truth.end)
    same = ends[0] == ends[1]
    assert same.mean() > 0.9
    change = np.abs(found[1] - found[0]) - np.abs(wanted[1] - wanted[0])
    unit = np.maximum(wanted[0], 1e-3 * wanted[0].max())
    # at the limb a pixel's tangent height has the digits of the planet's radius, 0.4 m of the last meters of air
    assert np.max((change / unit)[same]) < 2e-3
    assert np.percentile((change / unit)[same], 95) < 5e-5


@pytest.mark.parametrize("shape", SIZES)
def test_all_orders_in_slits(ctx, shape):
    """As users draw them, tiles and all orders: finite, and at every pixel no less than what is scattered once."""
    size = SIZES[shape]
    camera = horizon_camera(2.0, 60.0 if size[0] == 1 else 0.1)
    lights = [
        drawn(ctx, camera, size, replace(sa.quality.NAMED["balanced"], orders=orders))[0] for orders in ("all", 1)
    ]
    assert all(np.isfinite(light).all() and (light >= 0.0).all() for light in lights)
    assert np.all(lights[0] >= lights[1] * (1.0 - 2e-3))


@pytest.mark.parametrize("sun", SUNS)
def test_all_orders_from_everywhere(ctx, sun):
    """Finite, not negative, and not less than what is scattered once, with the moon's shadow in the air."""
    moon = sa.Occluder(tuple(3.0e8 * np.array(SUNS[sun])), 1.7e6)
    scene = sa.Scene(E, sa.Sun(SUNS[sun]), moon, sa.Surface(), sun_disc=True)
    with sa.Renderer(ctx, scene, (24, 16), EVERY) as renderer:
        for altitude in ALTITUDES.values():
            for camera in (usual_camera(altitude), horizon_camera(altitude, 0.01), horizon_camera(altitude, 175.0)):
                light = renderer.render(camera).numpy()
                assert np.isfinite(light).all() and (light >= 0.0).all()


def test_a_wrong_camera_would_be_noticed(ctx):
    """The rejected case: half a pixel aside."""
    camera, size = usual_camera(2.0), (24, 16)
    light, *_ = drawn(ctx, camera, size, ANALYTIC)
    aside = replace(camera, forward=direction(0.02, 0.7))
    assert light_error(light, twin(aside, size)).max() > 2.0 * LIGHT
