"""Properties that hold over the whole space of parameters: airs, eyes, rays, suns and moons, chosen by Hypothesis.

The choice is the same in every run. What once failed is kept as an explicit example. Whole scenes, frames and hosts:
tests/test_properties_scenes.py.
"""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import shadowatmo as sa
from shadowatmo import reference
from tests.strategies import any_airs, cameras, directions, examples, likely_airs, powers, rays_about

# few nodes: their shaders compile fast, and what is asked here holds for any number
QUALITY = sa.Quality(nodes=4, gap_nodes=2, orders=1, depth="analytic")
FINE = sa.Quality(nodes=16, gap_nodes=12, terms=6, orders=1)


def check_bounds(scene, found):
    """What holds for any air."""
    for name in (
        "transmittance",
        "single",
        "ground_direct",
        "lit",
        "shadow",
        "planet_umbra",
        "planet_penumbra",
        "umbra",
    ):
        values = getattr(found, name)
        assert np.isfinite(values).all(), name
        assert (values >= 0.0).all(), name
    assert (found.transmittance <= 1.0).all()
    miss = found.end == "miss"
    assert (found.transmittance[miss] == 1.0).all() and (found.single[miss] == 0.0).all()
    assert (found.ground_direct[found.end != "ground"] == 0.0).all()
    path = np.where(miss, 0.0, found.t_end - found.t_in)
    scale = scene.atmosphere.top_radius + np.where(miss, 0.0, found.t_in)
    assert np.all(np.abs(found.lit + found.shadow - path) <= 1e-5 * scale)
    # an albedo sends back at most itself of a sun's light, as a white wall does
    irradiance = sum(np.array(sun.irradiance) for sun in scene.suns)
    assert np.all(found.ground_direct <= irradiance * np.array(scene.atmosphere.ground_albedo) / np.pi * (1 + 1e-5))


def check_any(ctx, air, origins, rays, sun, moon):
    """Rays to the end of the air and cut, under a sun 1e4 planets away and a moon that shades much of the air."""
    distance = air.top_radius * 1e4
    body = sa.Occluder(tuple(1.7 * air.top_radius * np.array(moon)), 0.3 * air.top_radius)
    scene = sa.Scene(air, sa.Sun(sun, distance, 0.005 * distance), body)
    check_bounds(scene, sa.probe(ctx, scene, origins, rays, quality=QUALITY))
    t_max = air.thickness * 10.0 ** np.linspace(-3, 3, len(rays))
    check_bounds(scene, sa.probe(ctx, scene, origins, rays, t_max, quality=QUALITY))


@examples(20)
@given(data=st.data())
def test_any_air_is_finite_and_bounded(ctx, data):
    air = data.draw(any_airs())
    check_any(ctx, air, *data.draw(rays_about(air)), data.draw(directions()), data.draw(directions()))


NONE = (0.0, 0.0, 0.0)
# What Hypothesis once found: light of infinity minus infinity from eyes deep under the ground, where few nodes made of
# the columns of very thick air something below zero.
FAILURES = {
    "thick air in a deep shell": sa.Atmosphere(1e4, 1.01e6, (0.0, 0.0, 10.0), 1.0, NONE, NONE, 1.0, 0.0),
    "layers of centimeters around a sun": sa.Atmosphere(
        7.500943745472559e12, 7.795022911137275e12, (8.900366102080978e-06, 1.2324934949477716e-12, 0.0),
        0.033211514383124155, NONE, NONE, 186278.50307757463, 0.6291336458485367,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAILURES)
def test_what_once_failed(ctx, name, rng):
    air, count = FAILURES[name], 2000
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    heights = air.thickness * 10.0 ** rng.uniform(-6, 1, count) * rng.choice([1.0, -0.001], count)
    origins = up * np.maximum(air.bottom_radius + heights, 0.01 * air.bottom_radius)[:, None]
    rays = rng.normal(size=(count, 3))
    check_any(ctx, air, origins, rays / np.linalg.norm(rays, axis=1, keepdims=True), (0.3, 0.5, 0.2), (0.0, 1.0, 0.0))


@examples(12)
@given(data=st.data())
def test_likely_airs_are_those_of_the_twin(ctx, data):
    air = data.draw(likely_airs())
    origins, rays = data.draw(rays_about(air))
    scene = sa.Scene(air, sa.Sun(data.draw(directions())))
    found, twin = sa.probe(ctx, scene, origins, rays, quality=FINE), reference.probe(scene, origins, rays)
    check_bounds(scene, found)
    same = found.end == twin.end
    assert (~same).sum() <= 1  # a ray may graze the ground to a hair
    # 16 nodes, 12 in the dark: a few 1e-3 of an optical depth of 1 where one map serves layers of different heights
    assert np.max(np.abs(found.transmittance - twin.transmittance)[same]) < 3e-3
    scale = max(twin.single.max(), 1e-30)
    error = np.abs(found.single - twin.single)[same] / scale
    assert error.max() < 3e-2 and np.median(error) < 1e-4


@pytest.fixture(scope="module")
def renderer(ctx):
    with sa.Renderer(ctx, sa.Scene(), (13, 7), sa.Quality(nodes=4, depth="analytic")) as made:
        yield made


@examples(12)
@given(camera=cameras(), sun=directions(), moon=st.one_of(st.none(), directions()), near=powers(6.6, 9))
def test_any_camera_is_finite(renderer, camera, sun, moon, near):
    moons = () if moon is None else sa.Occluder(tuple(near * np.array(moon)), 1e6)
    renderer.scene = sa.Scene(sa.EARTH, sa.Sun(sun), moons, sun_disc=True)
    frame = renderer.render(camera)
    light, lit, shadow = frame.numpy(), frame.read("lit_width"), frame.read("shadow_width")
    for values in (light, lit, shadow):
        assert np.isfinite(values).all() and (values >= 0.0).all()
    # the longest path through the air
    assert (lit + shadow).max() < 2.0 * np.sqrt(sa.EARTH.top_radius**2 - sa.EARTH.bottom_radius**2) * (1 + 1e-5) or (
        np.linalg.norm(camera.position) < sa.EARTH.bottom_radius
    )


@examples(20)
@given(sun=directions(), seed=st.integers(0, 2**32 - 1), turn=directions())
def test_turning_the_world_changes_nothing(ctx, sun, seed, turn):
    """Scene and rays turned together: the light differs by rounding alone."""
    rng = np.random.default_rng(seed)
    up = rng.normal(size=(30, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    origins = up * (sa.EARTH.bottom_radius + 10.0 ** rng.uniform(0, 8, (30, 1)))
    rays = rng.normal(size=(30, 3)) - 0.8 * up
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    axis = np.array(turn)
    reflect = np.eye(3) - 2.0 * np.outer(axis, axis)
    one = sa.probe(ctx, sa.Scene(suns=sa.Sun(sun)), origins, rays, quality=QUALITY)
    other = sa.probe(ctx, sa.Scene(suns=sa.Sun(reflect @ sun)), origins @ reflect, rays @ reflect, quality=QUALITY)
    same = one.end == other.end
    assert same.sum() >= 29
    assert np.max(np.abs(one.transmittance - other.transmittance)[same]) < 1e-5
    assert np.max(np.abs(one.single - other.single)[same]) < 1e-4 * max(one.single.max(), 1e-12)


@examples(15)
@given(factor=st.floats(0.0, 1.0), sun=directions(), seed=st.integers(0, 2**32 - 1))
@example(factor=0.0, sun=(1.0, 0.0, 0.0), seed=1)
def test_light_grows_with_the_sun(ctx, factor, sun, seed):
    """Light is proportional to the sun's irradiance, and two suns add up."""
    origins = np.random.default_rng(seed).normal(size=(20, 3)) * 7e6
    rays = -origins + np.random.default_rng(seed + 1).normal(size=(20, 3)) * 5e6
    dim = sa.Scene(suns=sa.Sun(sun, irradiance=(factor,) * 3))
    full = sa.probe(ctx, sa.Scene(suns=sa.Sun(sun)), origins, rays, quality=QUALITY)
    part = sa.probe(ctx, dim, origins, rays, quality=QUALITY)
    both = sa.probe(ctx, sa.Scene(suns=(*dim.suns, sa.Sun(sun))), origins, rays, quality=QUALITY)
    assert np.allclose(part.single, factor * full.single, rtol=1e-6, atol=0.0)
    assert np.allclose(both.single, (1.0 + factor) * full.single, rtol=1e-6, atol=0.0)
