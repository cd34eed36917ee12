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
        defines, uniforms, samplers = eclipse_inputs(scene.suns[0], tables)
        defines = dict(defines)
        del defines["HAS_ECLIPSE"]
        return glsl(
            ["visibility.glsl"], "out0.x = sun_visibility(in0.xyz);", [points], uniforms, defines, samplers=samplers
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


def random_moon(rng, ratio):
    """A moon `ratio` times as large as the sun, as seen from the middle of the day side, whose shadow meets the air."""
    distance = 10 ** rng.uniform(7.0, 9.0)
    radius = distance * np.sin(min(ratio * SUN.radius / SUN.distance, 1.5))
    blur = distance * SUN.radius / SUN.distance
    shift = rng.uniform(-1, 1) * (radius + blur) + rng.choice([-1, 0, 1]) * radius
    side = rng.uniform(0, 2 * np.pi)
    return sa.Occluder((EARTH.bottom_radius + distance, shift * np.cos(side), shift * np.sin(side)), radius)


def test_every_size_and_separation(ctx, glsl, rng):
    """Annular, total, partial, grazing, 0.01 to 300 times the sun's size, points on both sides of the planet."""
    kinds = np.zeros(3, int)
    for ratio in np.geomspace(0.01, 300.0, 45):
        moon = random_moon(rng, ratio)
        scene = sa.Scene(suns=SUN, occluders=moon)
        if not shades_the_air(EARTH, SUN, moon):
            continue
        blur = moon.center[0] * SUN.radius / SUN.distance
        near_edge = rng.normal(size=(1200, 2)) * (moon.radius + blur) * 0.7 + np.array(moon.center[1:])
        anywhere = rng.normal(size=(400, 2)) * 4e6
        across = np.concatenate([near_edge, anywhere])
        across = across[np.hypot(*across.T) < EARTH.bottom_radius]
        sides = rng.choice([1, 1, -1], len(across)) * np.sqrt(EARTH.top_radius**2 - (across**2).sum(axis=1))
        points = np.column_stack([sides, across])
        found, truth = glsl_visibility(ctx, glsl, scene, points), visible_fraction(points, SUN, moon)
        assert np.isfinite(found).all() and np.abs(found - truth).max() < 1e-3, (ratio, moon)
        kinds += [np.any(truth == 0.0), np.any((truth > 0.0) & (truth < 1.0)), np.any(truth == 1.0)]
    assert (kinds > 10).all()


def test_a_satellite_within_reach_of_the_air(ctx, glsl, rng):
    """A body 20 km wide above and inside the air: points beyond it see the whole sun, points in it nothing."""
    for altitude in (1.2e5, 3e4):
        body = sa.Occluder((EARTH.bottom_radius + altitude, 0, 0), 1e4)
        across = rng.normal(size=(1500, 2)) * 8e3
        points = np.column_stack([EARTH.bottom_radius + rng.uniform(0, 2 * altitude, 1500), across])
        found = glsl_visibility(ctx, glsl, sa.Scene(suns=SUN, occluders=body), points)
        truth = visible_fraction(points, SUN, body)
        near = np.linalg.norm(points - body.center, axis=1)
        # 1 m: what float32 leaves of planet-centered points, seen from the body in radii of the sun
        doubt = 1e-3 + 1.0 / (np.maximum(near, 1.0) * SUN.radius / SUN.distance)
        outside = np.abs(near - body.radius) > 3.0
        assert np.isfinite(found).all() and (np.abs(found - truth) < doubt)[outside].all()
        assert (truth == 0.0).any() and (truth == 1.0).any()


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
        assert eclipse_inputs(SUN, {}) == ({}, {}, {})
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


