"""Moons before a sun that is setting by its finite disc: twin, shader and probe, jointly with the planet's limb."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference, terminator_moons
from shadowatmo.eclipse import disc_visibility, discs_before_sun, joint_discs, sun_visibility
from shadowatmo.passes.constants import medium_defines, transmittance_defines
from shadowatmo.passes.eclipse import Eclipse
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.passes.terminator import high_sun, terminator_defines
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from tests.cameras import SUN, level
from tests.test_terminator import ACCURATE, ALPHA, DISC, EARTH, QUICK, R

SUN_ACROSS = SUN.radius / SUN.distance
SIDE = np.cross(SUN.direction, (0.0, 0.0, 1.0))  # points on the terminator
BAR = 0.01  # of the light without a moon: 16 strips over chords with kinks leave 0.006


def moon(point, k, up, aside, distance=3.7e8):
    """Return a moon of `k` radii of the sun, (up, aside) radii from its center as seen from `point`."""
    sun = SUN.distance * np.array(SUN.direction) - point
    sun /= np.linalg.norm(sun)
    zenith = np.array(point) - sun * (point @ sun)
    zenith /= np.linalg.norm(zenith)
    offset = up * zenith + aside * np.cross(sun, zenith)
    center = np.array(point) + distance * (sun + SUN_ACROSS * offset)
    return sa.Occluder(tuple(center), k * SUN_ACROSS * distance)


def ground_point(elevation):
    """Return a point of the ground where the sun's center stands `elevation` [rad] above the horizon."""
    up = np.cos(elevation) * SIDE / np.linalg.norm(SIDE) + np.sin(elevation) * np.array(SUN.direction)
    return up * R


COVERS = {  # k, up, aside, distance of each moon
    "upper half": [(1.0, 0.7, 0.0)],
    "lower half": [(1.0, -0.7, 0.0)],
    "one side": [(1.0, 0.1, 0.8)],
    "annular": [(0.9, 0.0, 0.0)],
    "near moon": [(1.2, 0.8, 0.3, 1.5e7)],
    "two that overlap": [(0.6, 0.6, 0.0), (0.6, 0.2, 0.3, 2e8)],
}


def under(name, elevation, sun=DISC):
    """Return point and scene of one of COVERS."""
    point = ground_point(elevation)
    return point, sa.Scene(suns=sun, occluders=tuple(moon(point, *one) for one in COVERS[name]))


def ground_and_air(probe, scene, point):
    """Return (2, 3): light of the ground at `point`, and of a ray that rises steeply from 1 m above it."""
    up = point / np.linalg.norm(point)
    start = point + up
    result = probe(scene, [start, start], [-up, up + 0.1 * np.array(SUN.direction)])
    return np.stack([result.ground_direct[0], result.single[1]])


def strips_of(discs, last, u):
    """Return the free share of the light of strips above the horizon b = `last` by counting points of a fine grid."""
    x, y = np.meshgrid(*[(np.arange(1500) + 0.5) / 750 - 1.0] * 2)
    r2 = x * x + y * y
    light = np.where((r2 < 1.0) & (y > np.cos(last)), 1.0 - u * (1.0 - np.sqrt(np.maximum(1.0 - r2, 0.0))), 0.0)
    free = np.all([(y - up) ** 2 + (x - aside) ** 2 > k * k for up, aside, k in discs], axis=0)
    return (light * free).sum() / light.sum()


def random_discs(rng, count, moons):
    return np.stack([*rng.uniform(-1.2, 1.2, (2, count, moons)), rng.uniform(0.1, 2.0, (count, moons))], axis=2)


@pytest.mark.parametrize("moons", [1, 2, 4])
def test_strips_of_the_whole_disc_are_the_visible_fraction(rng, moons):
    discs = random_discs(rng, 60, moons)
    free, whole = terminator_moons.strip_weights(discs, 0.6, np.full(60, np.pi), 48)
    share = free.sum(axis=1) / whole.sum(axis=1)
    truth = joint_discs(discs, 0.6) if moons > 1 else disc_visibility(discs[:, 0, 2], np.hypot(*discs[:, 0, :2].T), 0.6)
    assert np.max(np.abs(share - truth)) < 1e-6  # 16 nodes from kink to kink
    assert np.max(np.abs(joint_discs(random_discs(rng, 60, 2), 0.6) - truth)) > 0.1


def test_strips_above_the_horizon_against_a_raster(rng):
    last = rng.uniform(0.4, 3.0, 8)
    discs = random_discs(rng, 8, 2)
    free, whole = terminator_moons.strip_weights(discs, 0.6, last, 48)
    truth = np.array([strips_of(*item, 0.6) for item in zip(discs, last, strict=True)])
    assert np.max(np.abs(free.sum(axis=1) / whole.sum(axis=1) - truth)) < 3e-3  # a grid of 1500
    assert np.max(np.abs(joint_discs(discs, 0.6) - truth)) > 0.05  # what a product takes


def test_strips_in_the_shader(glsl, rng):
    """Unions of three intervals, the same moon twice and thrice, moons as large as a half plane, slivers of strips."""
    discs = random_discs(rng, 3000, 3)
    discs[:500, 1] = discs[:500, 0]
    discs[:100, 2] = discs[:100, 0]
    discs[500:1000, 0] += (300.0, 0.0, 300.0)
    b = np.pi * rng.uniform(size=3000) ** rng.choice([1.0, 5.0], 3000)
    strip = np.cos(b).astype(np.float32), np.sin(b).astype(np.float32)
    code = "vec3 d[3] = vec3[3](in1.xyz, in2.xyz, in3.xyz); out0.xy = strip_light(d, in0.x, in0.y);"
    defines = {"DISC_MOONS": 3, "STRIP_RULE": 1, **terminator_defines(DISC, ACCURATE)}
    defines |= {**medium_defines(EARTH), **transmittance_defines(EARTH, ACCURATE)}
    del defines["HAS_TERMINATOR"]
    inputs = [np.stack(strip, axis=1), *np.moveaxis(discs, 1, 0)]
    got = glsl(["terminator_moons.glsl"], code, inputs, {"u_limb_darkening": 0.6}, defines)[:, :2]
    free, whole = (side[:, 0] for side in terminator_moons.free_light(discs, np.cos(b)[:, None], 0.6))
    # float32: the edge of a moon of 300 radii to 2e-4 of the sun's
    assert np.max(np.abs(got[:, 1] - whole)) < 1e-5 and np.max(np.abs(got[:, 0] - free)) < 5e-4
    alone = terminator_moons.free_light(discs[:, :1], np.cos(b)[:, None], 0.6)[0][:, 0]
    assert np.max(np.abs(got[:, 0] - alone)) > 0.5


def test_where_moons_stand_before_the_sun():
    point = ground_point(0.3 * ALPHA)
    one = moon(point, 0.8, 0.5, -0.25)
    disc = discs_before_sun(point[None], SUN, (one,), up=point[None])[0, 0]
    assert np.allclose(np.abs(disc), (0.5, 0.25, 0.8), rtol=0, atol=5e-4) and disc[0] > 0.0  # angles of 0.005


@pytest.mark.parametrize("cover", COVERS)
def test_probe_against_the_twin(ctx, cover):
    def probe(*args):
        return sa.probe(ctx, *args, quality=ACCURATE)

    products = []
    for elevation in ALPHA * np.array([-0.5, 0.0, 0.9, 4.0]):
        point, scene = under(cover, elevation)
        whole = ground_and_air(reference.probe, sa.Scene(suns=DISC), point)
        truth, got = (ground_and_air(p, scene, point) for p in (reference.probe, probe))
        scale = whole.max(axis=1, keepdims=True)
        assert np.max(np.abs(got - truth) / scale) < BAR, elevation
        products.append(np.abs(sun_visibility(scene, point) * whole - truth)[0].max() / scale[0, 0])
    assert max(products) > 2 * BAR  # the product of the two fractions fails the same check


def test_a_moon_before_the_part_that_is_up_leaves_nothing(ctx):
    """Half of the disc is set: the moon covers all of the other half, or a part of what is set anyway."""
    point = ground_point(0.0)
    for probe in (reference.probe, lambda *args: sa.probe(ctx, *args, quality=ACCURATE)):
        whole = ground_and_air(probe, sa.Scene(suns=DISC), point)[0]
        up, down = (
            ground_and_air(probe, sa.Scene(suns=DISC, occluders=moon(point, 3.0, side * 2.99, 0.0)), point)[0]
            for side in (1.0, -1.0)
        )
        # moons of 3 radii leave a lens at either end of the horizon
        assert np.all(up < 0.06 * whole) and np.all(up > 0.0)
        assert np.all(down > 0.94 * whole) and np.all(down < whole)


def test_totality_is_dark(ctx):
    for elevation in ALPHA * np.array([-0.9, 0.0, 0.9, 30.0]):
        point = ground_point(elevation)
        scene = sa.Scene(suns=DISC, occluders=moon(point, 1.05, 0.0, 0.0))
        for probe in (reference.probe, lambda *args: sa.probe(ctx, *args, quality=QUICK)):
            assert np.all(ground_and_air(probe, scene, point)[0] == 0.0)


def test_by_day_the_tables_decide(ctx):
    """With the sun high the light is that of a point sun times the visible fraction, from the same table."""
    for cover in COVERS:
        point, scene = under(cover, 1.2)
        hard = dataclasses.replace(scene, suns=SUN)
        for probe in (reference.probe, lambda *args: sa.probe(ctx, *args, quality=ACCURATE)):
            joint, product = (ground_and_air(probe, s, point) for s in (scene, hard))
            assert np.allclose(joint, product, rtol=2e-3)  # the air's light changes by 1e-3 over the disc
    other = under("annular", 1.2)[1]
    assert not np.allclose(ground_and_air(reference.probe, other, point), product, rtol=2e-3)


def test_moon_that_stands_aside_changes_nothing(ctx):
    point = ground_point(0.2 * ALPHA)
    aside = sa.Scene(suns=DISC, occluders=moon(point, 0.5, 2.0, 0.0))
    assert sun_visibility(aside, point) == 1.0
    for probe in (reference.probe, lambda *args: sa.probe(ctx, *args, quality=ACCURATE)):
        ground = [ground_and_air(probe, s, point)[0] for s in (aside, sa.Scene(suns=DISC))]
        assert np.array_equal(*ground)


def test_ring_multiplies(ctx):
    """A ring dims the part above the limb as it does the whole disc, with a moon beside it or without."""
    point, scene = under("upper half", 0.4 * ALPHA)
    # its plane, between the point and the sun, is crossed far from both edges: an even screen
    screen = sa.Ring((0.0, 0.0, 0.0), np.array(SUN.direction) - 0.3 * SIDE, 1e3, 1e9, 0.7)
    for probe in (reference.probe, lambda *args: sa.probe(ctx, *args, quality=ACCURATE)):
        plain, dimmed = (ground_and_air(probe, s, point)[0] for s in (scene, dataclasses.replace(scene, rings=screen)))
        assert np.allclose(dimmed, plain * screen.transmission(SUN), rtol=1e-3) and dimmed.max() < 0.6 * plain.max()


@pytest.mark.parametrize("tolerance", [0.0, 0.002], ids=["every pixel", "tiles"])
def test_frame_over_the_lit_ground(ctx, tolerance):
    """Ground and air of a frame at sunset: the twin's light in some pixels."""
    camera, size = level(89.9, 2.0, 0, -1, 20), (24, 16)
    point = np.array(camera.position)
    scene = sa.Scene(suns=DISC, occluders=moon(point, 1.0, 0.7, 0.0), surface=sa.Surface())
    quality = dataclasses.replace(QUICK, tolerance=tolerance)
    with sa.Renderer(ctx, scene, size, quality) as renderer:
        frame = renderer.render(camera).numpy()
    rays = camera.pixel_rays(size)[::5, 3::9].reshape(-1, 3)
    origins = np.tile(camera.position, (len(rays), 1))
    bare = dataclasses.replace(scene, surface=None)
    truth, whole = (reference.probe(s, origins, rays) for s in (bare, dataclasses.replace(bare, occluders=())))
    light, full = (np.nan_to_num(p.single + p.ground_direct) for p in (truth, whole))
    error = np.abs(frame[::5, 3::9].reshape(-1, 3) - light) / full.max(axis=1, keepdims=True)
    product = sun_visibility(scene, point) * full
    # 8 nodes and 2 strips, where the probe has more; the ground alone shows the product's error
    assert np.isfinite(frame).all() and error.max() < 2 * BAR
    assert (np.abs(product - light) / full.max(axis=1, keepdims=True)).max() > 10 * BAR


def test_who_asks_for_one_of_them_pays_nothing(ctx):
    words = ("disc_visibility", "strip_light", "u_strip_rule")
    moons = {"HAS_ECLIPSE": True, "HAS_MOON_TABLES": True, "HAS_NARROW_MOONS": True}
    disc = {"HAS_TERMINATOR": True}
    base = {"HAS_AIR": True, "HAS_SEGMENTS": True, "HAS_SHADOW": True}
    for name in ("probe.frag", "atmosphere.frag", "planet.frag"):
        for more in (moons, disc):
            features = {**base, **more}
            text = compose_source(name, features, optional=features).text
            assert not any(word in text for word in words), name
        features = {**base, **moons, **disc, "HAS_TERMINATOR_MOONS": True}
        text = compose_source(name, features, optional=features).text
        assert all(word in text for word in words), name
    scenes = [sa.Scene(suns=SUN, occluders=moon(SIDE * R, 1, 0, 0)), sa.Scene(suns=DISC), under("annular", 0.0)[1]]
    eclipse = Eclipse(ctx)
    for scene, asks in zip(scenes, (False, False, True), strict=True):
        tables = {}
        eclipse.draw(scene, tables)
        assert ("HAS_TERMINATOR_MOONS" in terminator_moons_inputs(scene.suns[0], tables)[0]) == asks
    eclipse.release()


def test_plan_tells(ctx):
    plans = []
    for scene in (under("annular", 0.0)[1], sa.Scene(suns=DISC), under("annular", 0.0, SUN)[1]):
        with sa.Renderer(ctx, scene, (8, 8), QUICK) as renderer:
            plans.append("less what moons hide" in str(renderer.plan))
    assert plans == [True, False, False]


def test_high_sun_begins_later_under_moons():
    assert high_sun(EARTH, DISC, moons=True) > 3.5 * high_sun(EARTH, DISC)
