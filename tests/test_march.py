"""The method "march": the shader against its twin, the twin against the truth, frames against the probe."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import march, reference
from shadowatmo.quality import Quality
from tests.cameras import CAMERAS, SUN
from tests.table_rays import cut_rays, make_rays, relative_errors, true_single


def rays_of(rng, name, count=60, atmosphere=sa.EARTH):
    """A set's rays, their suns and t_max, and what `march.scatter` takes of them."""
    origins, directions, suns, t_max = make_rays(atmosphere, rng, name, count)
    return (origins, directions, suns, t_max), cut_rays(atmosphere, origins, directions, suns, t_max)


def twin(cut, steps, atmosphere=sa.EARTH):
    ray, sun, cuts = cut
    return march.scatter(atmosphere, ray, sun[:, 0], sun[:, 1], cuts, steps)


def p90(got, truth):
    return np.nanpercentile(relative_errors(got, truth), 90)


@pytest.mark.parametrize("name, order, few", [("ground, day", 2, 32), ("limb", 1, 32), ("terrain cut", 2, 2)])
def test_more_steps_come_closer_to_the_truth(rng, name, order, few):
    """Middles are of second order where a path is lit, of first where the shadow's edge falls inside a step."""
    rays, cut = rays_of(rng, name)
    truth = true_single(sa.EARTH, *rays)
    errors = [p90(twin(cut, steps)[1], truth) for steps in (few, 4 * few, 16 * few)]
    # four times the steps are worth 4**order in the limit; half of that, as a power, is asked of coarse ones
    assert errors[0] > 2**order * errors[1] > 4**order * errors[2]
    assert errors[0] > 1e-3  # and the few are seen to be wrong


def test_the_shader_does_what_the_twin_does(ctx, rng):
    """The same steps, apart from the table of columns, whose cells are worth 1e-3 of the light near the horizon."""
    scene = sa.Scene(suns=sa.Sun(direction=(0.9, 0.0, 0.1)))
    (origins, directions, _, t_max), _ = rays_of(rng, "ground, low sun", 200)
    suns = np.broadcast_to(scene.suns[0].direction, origins.shape)
    for steps in (8, 64):
        transmittance, radiance = twin(cut_rays(sa.EARTH, origins, directions, suns, t_max), steps)
        got = sa.probe(ctx, scene, origins, directions, t_max, Quality(method="march", steps=steps, orders=1))
        assert np.abs(got.transmittance - transmittance).max() < 1e-4
        errors = relative_errors(got.single, radiance)
        assert np.nanpercentile(errors, 95) < 3e-3 and np.nanmax(errors) < 0.05
    truth = reference.probe(scene, origins, directions, t_max).single
    assert np.nanmax(relative_errors(got.single, truth)) > 5e-3  # 64 steps are not the truth itself


def test_frames_show_what_the_probe_finds(ctx):
    quality, size = Quality(method="march", steps=24, orders=1), (32, 18)
    for name in ("2 m, sunset", "400 km, sunset"):
        scene, camera = sa.Scene(suns=SUN), CAMERAS[name]
        with sa.Renderer(ctx, scene, size, quality, cache=False) as renderer:
            picture = renderer.render(camera).numpy()
            assert "transmittance" in renderer.plan and "24 uniform steps" in str(renderer.plan)
        tan_x, tan_y = camera.tangents(size)
        right, up, forward = camera.basis()
        x = (2 * (np.arange(size[0]) + 0.5) / size[0] - 1) * tan_x
        y = (1 - 2 * (np.arange(size[1]) + 0.5) / size[1]) * tan_y
        directions = (forward + x[None, :, None] * right + y[:, None, None] * up).reshape(-1, 3)
        rays = np.broadcast_to(camera.position, directions.shape), directions
        single = sa.probe(ctx, scene, *rays, quality=quality).single.reshape(picture.shape)
        # pixels whose step falls just on either side of the shadow's edge may differ; the rest is float32
        errors = np.abs(picture - single) / np.maximum(single, 1e-4 * single.max())
        assert np.median(errors) < 1e-4 and np.percentile(errors, 99) < 2e-2


def test_moons_shade_every_step(ctx):
    moon = sa.Occluder(center=(3.75e8, 0.0, 0.0), radius=1.7374e6)
    scene = sa.Scene(suns=SUN, occluders=moon)
    origins, directions = np.array([[6.36e6 + 2.0, 0.0, 0.0]]), np.array([[0.2, 1.0, 0.1]])
    quality = Quality(method="march", steps=256, orders=1)
    got = sa.probe(ctx, scene, origins, directions, quality=quality).single
    truth = reference.probe(scene, origins, directions).single
    free = reference.probe(sa.Scene(suns=SUN), origins, directions).single
    assert np.all(got < 0.5 * free)
    assert np.abs(got - truth).max() < 0.02 * free.max()  # 256 steps


def test_multiple_scattering_is_added_as_to_segments(ctx):
    scene, rays = sa.Scene(suns=SUN), (np.array([[0.0, 6.36e6 + 10.0, 0.0]]), np.array([[1.0, 0.3, 0.2]]))
    one, other = (sa.probe(ctx, scene, *rays, quality=Quality(method=m)).multiple for m in ("march", "segments"))
    assert one.min() > 0 and np.allclose(one, other, rtol=1e-2)


@pytest.mark.parametrize("steps", [0, 1025, 3.0, True])
def test_steps_are_checked(steps):
    with pytest.raises(sa.ParameterError, match="steps"):
        Quality(steps=steps)


def test_a_surface_is_lit_through_the_same_table(ctx):
    scene = sa.Scene(suns=SUN, surface=sa.Surface())
    with sa.Renderer(ctx, scene, (16, 9), Quality(method="march"), cache=False) as renderer:
        marched = renderer.render(CAMERAS["10 km, low sun"]).numpy()
    with sa.Renderer(ctx, scene, (16, 9), "balanced", cache=False) as renderer:
        assert np.allclose(renderer.render(CAMERAS["10 km, low sun"]).numpy(), marched, rtol=0.2)  # 32 steps
