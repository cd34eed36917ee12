"""Rings: the closed form against a sun made of many points, the shader against the twin, shadow bands in frames."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.eclipse import joint_visibility, visibility
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.ring import chord_polynomial, dims_the_air, light_beyond_chord, ring_visibility
from tests.test_eclipse_pass import glsl_visibility

# Saturn's proportions at the size of the Earth
SUN = sa.Sun(direction=(0.85, 0.2, 0.45), distance=1.4e11, radius=6.957e8)
PLANET = sa.EARTH
B = sa.Ring((0, 0, 0), (0, 0, 1), 1.53 * PLANET.bottom_radius, 1.95 * PLANET.bottom_radius, 1.5)
A = sa.Ring((0, 0, 0), (0, 0, 1), 2.03 * PLANET.bottom_radius, 2.27 * PLANET.bottom_radius, 0.5)
TILTED = sa.Ring((2e8, 1e7, 3e7), (0.3, -0.5, 0.8), 5e6, 9e7, 0.7)


def points_of_air(rng, count):
    x = rng.normal(size=(count, 3))
    return x / np.linalg.norm(x, axis=1)[:, None] * rng.uniform(PLANET.bottom_radius, PLANET.top_radius, (count, 1))


def by_many_suns(points, sun, ring, rings=60, spokes=96, moon=None):
    """Mean transmission (N,) over points of the sun's disc, weighted by its light."""
    r = np.sqrt((np.arange(rings) + 0.5) / rings)
    a = 2 * np.pi * (np.arange(spokes) + 0.5) / spokes
    light = 1 - sun.limb_darkening * (1 - np.sqrt(1 - r**2))
    to_sun = sun.distance * np.array(sun.direction) - points
    far = np.linalg.norm(to_sun, axis=1, keepdims=True)
    axis = to_sun / far
    side = np.cross(axis, [0.3, 0.1, 0.9])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(axis, side)
    total = np.zeros(len(points))
    for radius, weight in zip(r, light, strict=True):
        for angle in a:
            shift = radius * sun.radius / far
            ray = axis + shift * (np.cos(angle) * side + np.sin(angle) * other)
            ray /= np.linalg.norm(ray, axis=1, keepdims=True)
            slant = ray @ np.array(ring.normal)
            path = (np.array(ring.center) - points) @ np.array(ring.normal) / slant
            place = np.linalg.norm(points + path[:, None] * ray - ring.center, axis=1)
            hit = (path > 0) & (place > ring.inner_radius) & (place < ring.outer_radius)
            passed = np.where(hit, np.exp(-ring.optical_depth / np.abs(slant)), 1.0)
            if moon is not None:
                passed = passed * (np.linalg.norm(np.cross(moon.center - points, ray), axis=1) > moon.radius)
            total += weight * passed
    return total / (light.sum() * spokes)


def near_edges(rng, sun, ring, count):
    """Points of the air whose line to the sun meets a ring's edges, within three radii of the sun's image."""
    points = points_of_air(rng, 60000)
    value = ring_visibility(points, sun, ring)
    return points[(value < 1 - 1e-4) & (value > ring.transmission(sun) + 1e-4)][:count]


@pytest.mark.parametrize("ring", [B, A, TILTED])
def test_closed_form_against_many_suns(rng, ring):
    points = np.concatenate([near_edges(rng, SUN, ring, 60), points_of_air(rng, 60)])
    error = np.abs(ring_visibility(points, SUN, ring) - by_many_suns(points, SUN, ring))
    # 5760 suns: a chord passes through about 100 of their cells, half of each at random
    assert len(points) > 80 and error.max() < 4e-3
    sharp = dataclasses.replace(SUN, radius=1e3)
    assert np.abs(ring_visibility(points, sharp, ring) - by_many_suns(points, SUN, ring)).max() > 0.1


@pytest.mark.parametrize("u", [0.0, 0.6, 1.0])
def test_light_beyond_a_chord(u):
    s = np.linspace(-1, 1, 401)
    x = np.linspace(-1, 1, 20001)
    strip = (1 - u) * 2 * np.sqrt(1 - x * x) + u * np.pi / 2 * (1 - x * x)  # light of a strip, in closed form
    counted = np.array([np.trapezoid(np.where(x >= v, strip, 0), x) for v in s]) / np.trapezoid(strip, x)
    assert np.abs(light_beyond_chord(s, u) - counted).max() < 2e-4
    a = chord_polynomial(u)
    polynomial = 0.5 - s * (a[0] + a[1] * s**2 + a[2] * s**4 + a[3] * s**6)
    assert np.abs(polynomial - light_beyond_chord(s, u)).max() < 1e-3
    assert polynomial[0] == pytest.approx(1, abs=1e-12) and polynomial[-1] == pytest.approx(0, abs=1e-12)


def test_shader_against_twin(ctx, glsl, rng):
    moon = sa.Occluder(tuple(2e8 * np.array(SUN.direction) + [0, 2e6, 0]), 1.5e6)
    for rings, moons in (((B, A), ()), ((TILTED,), ()), ((B,), (moon,)), ((A, B, TILTED), (moon,))):
        scene = sa.Scene(suns=SUN, rings=rings, occluders=moons)
        points = np.concatenate([points_of_air(rng, 2000), *(near_edges(rng, SUN, ring, 500) for ring in rings)])
        truth = visibility(points, SUN, scene)
        error = np.abs(glsl_visibility(ctx, glsl, scene, points) - truth)
        assert error.max() < 2e-3 and truth.min() < 0.7, (rings, moons)


def test_a_moon_before_a_rings_edge(rng):
    """A ring dims what a moon leaves of the sun: cells of the disc against the twin, beside the product of both."""
    axis = np.array(SUN.direction)
    points = near_edges(rng, SUN, B, 12)
    errors, products = [], []
    for point in points:
        moon = sa.Occluder(tuple(point + 2e8 * (axis + 2e-3 * rng.normal(size=3))), 0.8e6)
        scene = sa.Scene(suns=SUN, rings=B, occluders=moon)
        found = visibility(point[None], SUN, scene)[0]
        errors.append(abs(found - by_many_suns(point[None], SUN, B, moon=moon)[0]))
        product = joint_visibility(point[None], SUN, (moon,))[0] * ring_visibility(point[None], SUN, B)[0]
        products.append(abs(found - product))
    assert np.max(errors) < 6e-3 and np.max(products) > 0.02


def test_bands_of_light_in_rays(ctx, rng):
    scene = sa.Scene(suns=SUN, rings=(B, A))
    origins = np.tile(np.array([1.2e7, 2e6, -6e6]), (60, 1))
    aim = points_of_air(rng, 60) * 0.99
    truth = reference.probe(scene, origins, aim - origins)
    got = sa.probe(ctx, scene, origins, aim - origins, quality=sa.Quality(nodes=20, gap_nodes=10, terms=6, orders=1))
    clear = reference.probe(sa.Scene(suns=SUN), origins, aim - origins)
    brightest = clear.single.max(axis=1, keepdims=True)
    error = np.abs(got.single - truth.single) / np.maximum(brightest, 0.01 * brightest.max())
    # rays cross the edges of bands, and quadrature knows nothing of them
    assert np.median(error) < 2e-3 and np.percentile(error, 95) < 0.02
    assert np.max(np.abs(clear.single - truth.single) / np.maximum(brightest, 0.01 * brightest.max())) > 0.3
    ground = truth.end == "ground"
    assert np.abs(got.ground_direct - truth.ground_direct)[ground].max() < 2e-3 * clear.ground_direct.max()


def test_only_rings_whose_shadow_meets_the_air_count(ctx):
    camera = sa.Camera(position=(2e7, 0, 0), target=(0, 0, 0), vertical_fov=1.0)
    away = sa.Ring((0, 0, 1e8), (0, 0, 1), 1e6, 2e6, 1.0)
    assert dims_the_air(PLANET, SUN, B) and not dims_the_air(PLANET, SUN, away)
    assert not dims_the_air(PLANET, dataclasses.replace(SUN, direction=(1, 0, 0)), B)  # edge-on
    with sa.Renderer(ctx, sa.Scene(suns=SUN, rings=away), (8, 8)) as renderer:
        assert "eclipse" not in renderer.plan
        renderer.scene = sa.Scene(suns=SUN, rings=B)
        assert "eclipse" in renderer.plan and "1 rings" in str(renderer.plan)
        assert np.isfinite(renderer.render(camera).numpy()).all()
    text = compose_source("probe.frag", {"HAS_ECLIPSE": True}, optional={"HAS_ECLIPSE"}).text
    assert "ring_visibility" not in text and "u_ring" not in text


def test_a_ring_is_checked():
    for values, name in (((1e6, 1e6), "outer_radius"), ((-1, 1e6), "inner_radius")):
        with pytest.raises(sa.ParameterError) as caught:
            sa.Ring((0, 0, 0), (0, 0, 1), *values, 1.0)
        assert caught.value.name == name
    with pytest.raises(sa.ParameterError):
        sa.Ring((0, 0, 0), (0, 0, 1), 1e6, 2e6, -1.0)
    with pytest.raises(sa.ParameterError):
        sa.Scene(rings=5)
    assert joint_visibility(np.zeros((1, 3)), SUN, ()) == 1.0
