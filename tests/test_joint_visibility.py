"""Several moons at once: joint.glsl and the twin against counting, the map of overlaps, what decides about it."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.eclipse import disc_visibility, joint_discs, joint_visibility
from shadowatmo.moon_shadows import is_narrow, overlap_box, sun_axes
from shadowatmo.passes.eclipse import MAX_DISCS, EclipseMoons, joint_defines
from shadowatmo.passes.gl.source import compose_source
from tests.cameras import SUN
from tests.test_eclipse_pass import glsl_visibility

EARTH = sa.EARTH
CELLS = 500  # across the sun's disc


def counted(discs, u):
    """Visible fractions (N,) behind discs (N, M, 3) by counting cells, each limb smoothed over one cell."""
    grid = (np.arange(CELLS) + 0.5) / CELLS * 2.0 - 1.0
    x, y = np.meshgrid(grid, grid)
    light = 1.0 - u * (1.0 - np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0)))
    light *= np.clip((1.0 - np.hypot(x, y)) * CELLS / 2.0 + 0.5, 0.0, 1.0)
    result = []
    for row in discs:
        free = np.ones_like(x)
        for cx, cy, k in row:
            free = np.minimum(free, np.clip((np.hypot(x - cx, y - cy) - k) * CELLS / 2.0 + 0.5, 0.0, 1.0))
        result.append((light * free).sum() / light.sum())
    return np.array(result)


def random_discs(rng, count, moons, low, high):
    """Discs (count, moons, 3) that touch the sun's, sizes between low and high; some equal, some concentric."""
    k = np.exp(rng.uniform(np.log(low), np.log(high), (count, moons)))
    delta = np.abs(k - 1.0) * (k > 1.0) + rng.uniform(0, 1, (count, moons)) * (1.0 + k - np.abs(k - 1.0) * (k > 1.0))
    angle = rng.uniform(0, 2 * np.pi, (count, moons))
    discs = np.stack([delta * np.cos(angle), delta * np.sin(angle), k], axis=2)
    discs[: count // 20, 1] = discs[: count // 20, 0]
    discs[count // 20 : count // 10, 1, :2] = discs[count // 20 : count // 10, 0, :2]
    discs[count // 10 : count // 8, 0, :2] = 0.0
    return discs


def glsl_joint(glsl, discs, u):
    """Return what joint.glsl leaves of the sun behind discs (N, M, 3), M <= 8."""
    moons = discs.shape[1]
    fill = "".join(f"discs[{i}] = in{i}.xyz;" for i in range(moons))
    code = f"vec3 discs[MAX_DISCS]; {fill} out0.x = 1.0 - hidden_by_all(discs);"
    uniforms = {"u_limb_darkening": u, "u_disc_count": moons}
    return glsl(["joint.glsl"], code, [discs[:, i] for i in range(moons)], uniforms, joint_defines())[:, 0]


@pytest.mark.parametrize("moons", [2, 3, 5, 8])
def test_random_discs_against_counting(ctx, glsl, rng, moons):
    """The issue's bar: 99 of 100 within 2e-3; counting itself is good to 1e-4."""
    discs = np.concatenate([random_discs(rng, 50, moons, *sizes) for sizes in ((0.1, 0.6), (0.3, 1.5), (0.05, 5.0))])
    truth = counted(discs, 0.6)
    for found in (glsl_joint(glsl, discs, 0.6), joint_discs(discs, 0.6)):
        error = np.abs(found - truth)
        assert np.percentile(error, 99) < 1e-3 and error.max() < 2e-3
    each = disc_visibility(discs[..., 2], np.hypot(discs[..., 0], discs[..., 1]), 0.6)
    assert np.percentile(np.abs(np.maximum(each.sum(axis=1) - moons + 1, 0) - truth), 90) > 0.02  # a sum is not enough


@pytest.mark.parametrize("u", [0.0, 0.6, 1.0])
def test_shader_against_twin(ctx, glsl, rng, u):
    for moons, low, high in ((2, 0.01, 300.0), (4, 0.05, 5.0), (8, 0.3, 3.0), (3, 3.0, 300.0)):
        discs = random_discs(rng, 300, moons, low, high)
        found = glsl_joint(glsl, discs, u)
        error = np.abs(found - joint_discs(discs, u))
        assert np.isfinite(found).all() and np.percentile(error, 99) < 5e-4, (moons, low, high)
        # three limbs that meet within float32's doubt may lose a stretch between them
        assert np.percentile(error, 99.8) < 1e-3, (moons, low, high)


def around(rng, count=3000):
    """Points (count, 3) [m] of the air, most of them near the line from the planet's center to the sun."""
    across = rng.normal(size=(count, 2)) * 1.5e6
    height = np.sqrt(np.maximum(EARTH.bottom_radius**2 - (across**2).sum(axis=1), 0.0)) + rng.uniform(0, 6e4, count)
    return np.column_stack([height, across])


MOON = sa.Occluder(center=(3.7e8, 1e6, 0.5e6), radius=1.7374e6)
SETS = {
    "two": (MOON, sa.Occluder(center=(5e8, -0.8e6, 0.0), radius=1.6e6)),
    "one behind the other": (MOON, sa.Occluder(center=(7.4e8, 2e6, 1e6), radius=1.6e6)),
    "large and near": (sa.Occluder(center=(3e7, 3.2e6, 0.0), radius=3e6), MOON),
    "eight": tuple(
        sa.Occluder(center=(3e8 + 2e7 * i, 1.5e6 * np.cos(i), 1.5e6 * np.sin(i)), radius=5e5 + 1.5e5 * i)
        for i in range(8)
    ),
}


@pytest.mark.parametrize("name", SETS)
def test_overlapping_moons_in_the_air(ctx, glsl, rng, name):
    scene = sa.Scene(suns=SUN, occluders=SETS[name])
    points = around(rng)
    truth = joint_visibility(points, SUN, scene.occluders)
    error = np.abs(glsl_visibility(ctx, glsl, scene, points) - truth)
    # cells of the map are 14 km wide; the near moon's edge, 140 km wide, has a kink between them
    assert np.percentile(error, 99) < (2e-3 if name == "large and near" else 1e-3) and error.max() < 6e-3
    each = [joint_visibility(points, SUN, (moon,)) for moon in scene.occluders]
    assert np.max(np.abs(np.maximum(np.sum(each, axis=0) - len(each) + 1, 0) - truth)) > 0.02


def test_only_moons_that_can_overlap_get_a_map():
    aside = dataclasses.replace(MOON, center=(3.7e8, -9e6, 0.5e6))
    assert overlap_box(EARTH, SUN, (MOON, aside)) is None
    assert overlap_box(EARTH, SUN, SETS["two"]) is not None
    pair, single = (sa.Scene(suns=SUN, occluders=o) for o in (SETS["two"], (MOON, aside)))
    assert "HAS_OVERLAPS" in EclipseMoons(pair, SUN).defines()
    defines = EclipseMoons(single, SUN).defines()
    text = compose_source("probe.frag", defines, optional=defines).text
    assert "u_visibility" in text and "overlap" not in text


def test_box_holds_every_overlap(rng):
    for _ in range(60):
        moons = tuple(
            sa.Occluder((rng.uniform(2e7, 6e8), *rng.normal(size=2) * 5e6), 10 ** rng.uniform(5, 6.5)) for _ in range(2)
        )
        points = rng.normal(size=(4000, 3))
        points *= EARTH.top_radius * rng.uniform(0, 1, (4000, 1)) ** (1 / 3) / np.linalg.norm(points, axis=1)[:, None]
        each = np.stack([joint_visibility(points, SUN, (moon,)) for moon in moons])
        both = points[(each < 1.0 - 1e-9).all(axis=0)] @ sun_axes(SUN)
        box = overlap_box(EARTH, SUN, moons)
        assert not both.size or ((both > box[0] - 1.0) & (both < box[1] + 1.0)).all()


def test_what_counts_as_narrow():
    assert is_narrow(EARTH, SUN, MOON)
    assert not is_narrow(EARTH, SUN, dataclasses.replace(MOON, center=(3.7e7, 0, 0)))  # ten times as large
    assert not is_narrow(EARTH, SUN, sa.Occluder((6.6e6, 0, 0), 50.0))  # within a satellite's reach of the air
    assert MAX_DISCS == 8


def test_eight_occluders_and_three_suns(ctx, rng):
    """Each sun has its own moons; the frame and the probe are the sum over the suns, each against the twin."""
    second = sa.Sun((0.2, 1.0, 0.3), irradiance=(0.5, 0.3, 0.2))
    suns = (SUN, second, sa.Sun((0.3, 0.1, -1.0), irradiance=(0.1, 0.2, 0.4)))
    moons = [MOON, SETS["two"][1]]
    for sun, shift in ((suns[1], 0.0), (suns[1], 2e6), (suns[2], 1e6)):
        center = 3.6e8 * np.array(sun.direction) + shift * np.array([0.5, 0.5, 0.0])
        moons.append(sa.Occluder(tuple(center), 1.6e6))
    moons += [sa.Occluder((0.0, -3e8, 1e7 * i), 1.5e6) for i in range(3)]  # in nobody's light
    scene = sa.Scene(suns=suns, occluders=tuple(moons))
    assert [len(EclipseMoons(scene, sun)) for sun in suns] == [2, 2, 1]
    assert [EclipseMoons(scene, sun).box is not None for sun in suns] == [True, True, False]
    aim = rng.normal(size=(14, 3)) * 4e6
    origins = np.tile((1.5e7, 1.5e7, -1e7), (14, 1))
    truth = reference.probe(scene, origins, aim - origins)
    found = sa.probe(ctx, scene, origins, aim - origins, quality=sa.Quality(nodes=20, gap_nodes=10, terms=6, orders=1))
    hit = truth.end != "miss"
    assert hit.sum() > 8
    bright = reference.probe(sa.Scene(suns=suns), origins, aim - origins)
    for field in ("single", "ground_direct"):
        error = np.abs(getattr(found, field) - getattr(truth, field))[hit]
        assert np.percentile(error, 95) < 2e-3 * getattr(bright, field).max(), field
        assert np.abs(getattr(bright, field) - getattr(truth, field)).max() > 0.05 * getattr(bright, field).max()
    camera = sa.Camera(position=(1.5e7, 1.5e7, -1e7), target=(0, 0, 0), vertical_fov=0.8)
    with sa.Renderer(ctx, scene, (48, 27), sa.Quality(depth="analytic", orders=1)) as renderer:
        whole = renderer.render(camera).numpy()
        parts = np.zeros_like(whole)
        for sun in suns:
            renderer.scene = sa.Scene(suns=sun, occluders=tuple(moons))
            parts += renderer.render(camera).numpy()
    assert np.abs(whole - parts).max() < 1e-5 * whole.max()
