"""Moons' shadows in the air: the shader's visibility, which moons count, single scattering against the cases."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.eclipse import joint_visibility, visible_fraction
from shadowatmo.passes.eclipse import Eclipse, eclipse_inputs, shades_the_air
from shadowatmo.passes.gl.source import compose_source
from tests.cameras import SUN
from tests.test_probe import SINGLE, probed

EARTH = sa.EARTH
MOON = sa.Occluder(center=(3.7e8, 2e6, 1e6), radius=1.7374e6)


def glsl_visibility(ctx, glsl, scene, points):
    """Return what eclipse.glsl makes of points (N, 3)."""
    tables = {}
    eclipse = Eclipse(ctx)
    try:
        eclipse.draw(scene, tables)
        defines, uniforms, samplers = eclipse_inputs(scene, scene.suns[0], tables)
        del defines["HAS_ECLIPSE"]
        return glsl(
            ["eclipse.glsl"], "out0.x = sun_visibility(in0.xyz);", [points], uniforms, defines, samplers=samplers
        )[:, 0]
    finally:
        eclipse.release()


# sizes of a moon as seen from the planet, in units of the sun's: annular, equal, total, a giant
@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.95, 1.0, 1.04, 3.0, 30.0, 300.0])
def test_visible_fraction_in_the_shader(ctx, glsl, rng, ratio):
    distance = 3.7e8
    radius = distance * np.sin(ratio * SUN.radius / SUN.distance)
    # the edge of the shadow, or for a small moon its middle, falls on the planet
    moon = sa.Occluder(center=(distance, -max(radius - 1e6, 0.0), 0), radius=radius)
    scene = sa.Scene(suns=SUN, occluders=moon)
    offset = rng.uniform(-6.3e6, 6.3e6, 2000)
    points = np.stack([np.sqrt(EARTH.top_radius**2 - offset**2), offset, np.zeros(2000)], axis=1)
    error = np.abs(glsl_visibility(ctx, glsl, scene, points) - visible_fraction(points, SUN, moon))
    # a table of 256 separations, and float32 angles: 1e-3 of full sunlight is asked for
    assert error.max() < 1e-3
    if ratio >= 0.95:
        values = visible_fraction(points, SUN, moon)
        assert values.min() < 0.3 and values.max() > 0.9


def test_moons_that_do_not_overlap_add_up(ctx, glsl, rng):
    other = dataclasses.replace(MOON, center=(3.7e8, -4e6, 0.0))
    scene = sa.Scene(suns=SUN, occluders=(MOON, other))
    offset = rng.uniform(-5.5e6, 5.5e6, 1000)
    points = np.stack([np.sqrt(EARTH.top_radius**2 - offset**2), offset, np.zeros(1000)], axis=1)
    truth = joint_visibility(points, SUN, scene.occluders)
    assert np.max(np.abs(glsl_visibility(ctx, glsl, scene, points) - truth)) < 2e-3 and truth.min() < 0.5


def test_which_moons_reach_the_air():
    assert shades_the_air(EARTH, SUN, MOON)
    for center in ((-3.7e8, 0, 0), (3.7e8, 2e7, 0), (0, 3.7e8, 0), (1.6e11, 0, 0)):
        assert not shades_the_air(EARTH, SUN, dataclasses.replace(MOON, center=center)), center
    sides = np.linspace(0, 3e7, 301)
    edge = [shades_the_air(EARTH, SUN, dataclasses.replace(MOON, center=(3.7e8, y, 0))) for y in sides]
    assert edge[0] and not edge[-1] and np.count_nonzero(np.diff(edge)) == 1
    # the penumbra of the Moon is about 3.5e6 m wide at the Earth
    assert abs(sides[np.argmin(edge)] - (EARTH.top_radius + 3.5e6)) < 4e5


def test_single_scattering_of_the_reference_cases(ctx):
    errors = []
    for case, got in probed(ctx, "eclipse_single", SINGLE):
        base = np.array(case["expected"]["single_no_moon"])
        errors.append(np.abs(got["single"] - case["expected"]["single"]) / base.max())
    # 20 nodes and no split at the umbra: relative to the air without a moon
    assert np.percentile(errors, 95) < 5e-4 and np.max(errors) < 2e-3


def test_ground_in_the_penumbra(ctx, rng):
    scene = sa.Scene(suns=SUN, occluders=MOON)
    aim = np.array([np.sqrt(EARTH.bottom_radius**2 - 8e12), 2e6, 2e6]) + rng.normal(size=(200, 3)) * 1e6
    origins = np.tile([2e7, 0, 0], (200, 1))
    got, truth = (p(scene, origins, aim - origins) for p in (lambda *a: sa.probe(ctx, *a), reference.probe))
    hit = truth.end == "ground"
    assert hit.sum() > 150
    assert np.max(np.abs(got.ground_direct - truth.ground_direct)[hit]) < 2e-3 * truth.ground_direct.max()
    clear = reference.probe(sa.Scene(suns=SUN), origins, aim - origins)
    assert np.median(truth.ground_direct[hit, 1] / clear.ground_direct[hit, 1]) < 0.9  # the moon does shade them


def test_a_scene_without_shading_moons_pays_nothing(ctx):
    away = sa.Scene(suns=SUN, occluders=sa.Occluder(center=(0, 3.7e8, 0), radius=1.7e6))
    with sa.Renderer(ctx, away, (8, 8)) as renderer:
        assert "eclipse" not in renderer.plan and "no occluder's penumbra" in str(renderer.plan)
        assert eclipse_inputs(away, SUN, {}) == ({}, {}, {})
    with sa.Renderer(ctx, sa.Scene(suns=SUN, occluders=MOON), (8, 8)) as renderer:
        assert "eclipse" in renderer.plan
    features = {"HAS_AIR": True, "HAS_SEGMENTS": True}
    for name in ("probe.frag", "atmosphere.frag"):
        assert "visib" not in compose_source(name, features, optional=features).text


def test_totality_darkens_the_frame_and_hides_the_disc(ctx):
    up = np.array([1.0, 0.0, 0.0])
    camera = sa.Camera(position=6.3605e6 * up, forward=up, up=(0, 0, 1), vertical_fov=np.radians(4))
    total = sa.Occluder(center=(3.66e8, 0, 0), radius=1.7374e6)
    frames = []
    for occluders in ((), (total,)):
        with sa.Renderer(ctx, sa.Scene(suns=SUN, occluders=occluders, sun_disc=True), (161, 161)) as renderer:
            frames.append(renderer.render(camera).numpy())
    assert frames[0][80, 80, 1] > 1e3 and frames[1].max() < 1e-3 * frames[0][10, 10].max() + 1e-6


