"""Multiple scattering under moons: the volume's frame and map, the solve against its twin and the reference cases."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.eclipse import visible_fraction
from shadowatmo.eclipse_gather import RatioVolume, solve_ratio
from shadowatmo.eclipse_multiple import (
    RatioGrid,
    RatioRecipe,
    azimuth_harmonics,
    shade,
    shadow_frame,
    zenith_harmonics,
)
from shadowatmo.medium import densities
from shadowatmo.multiple import solve
from shadowatmo.multiple_recipes import Effort, Recipe
from shadowatmo.passes.constants import medium_defines, medium_uniforms
from shadowatmo.passes.eclipse import Eclipse, shading_occluders
from shadowatmo.passes.eclipse_multiple import EclipseMultiple, ratio_inputs
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.multiple import MultipleScattering, multiple_defines, multiple_samplers, multiple_uniforms
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.shadow import penumbra_cone
from tests.cameras import SUN
from tests.test_probe import probed

EARTH, R = sa.EARTH, sa.EARTH.bottom_radius
TABLE = Recipe(heights=8, suns=16, polar=8, azimuths=6, degree=4, orders=3)
SMALL = RatioRecipe(6, 3, 3, 2, 4, Effort(4, 3, 6, 4), Effort(3, 2, 4, 3), 1)


def moon(zenith, beside=0.0, distance=3.66e8):
    """Return a moon whose shadow's axis meets the ground at a solar zenith angle [degrees], moved `beside` [m]."""
    angle = np.radians(zenith)
    spot = R * np.array([np.cos(angle), np.sin(angle), 0.0])
    to_sun = SUN.distance * np.array(SUN.direction) - spot
    return sa.Occluder(center=spot + distance * to_sun / np.linalg.norm(to_sun) + [0.0, 0.0, beside], radius=1.7374e6)


def eclipse(zenith, **more):
    """Return a scene in the moon's shadow, and the unit vector to the middle of the shadow on the ground."""
    scene = sa.Scene(suns=SUN, occluders=moon(zenith, **more))
    return scene, shadow_frame(EARTH, SUN, scene.occluders[0]).axes[2]


# overhead, low, over the edge of the planet: the squeeze is 1, between, at its least
@pytest.mark.parametrize("zenith", [0.0, 40.0, 85.0])
def test_frame_and_map_are_round_trips(rng, zenith):
    frame = shadow_frame(EARTH, SUN, moon(zenith))
    assert np.allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-12)
    assert frame.axes[2] @ SUN.direction == pytest.approx(np.cos(np.radians(zenith)), abs=1e-9)
    assert abs(frame.axes[1] @ SUN.direction) < 1e-12  # sun and moon in the plane of symmetry
    ring, sector = rng.uniform(0.02, 0.7, 500), rng.uniform(0.02, 0.98, 500)
    back = frame.place(frame.up(ring, sector))
    assert np.allclose(back[0], ring, atol=1e-9) and np.allclose(back[1], sector, atol=1e-9)
    assert np.all(back[2] == 1.0)
    mirrored = frame.up(ring, sector) @ frame.axes.T * [1.0, -1.0, 1.0] @ frame.axes
    again = frame.place(mirrored)
    assert np.allclose(again[:2], back[:2]) and np.all(again[2] == -1.0)
    # the umbra's edge lies inside, where rings are close
    edge = frame.place(frame.up(np.array([0.5]), np.array([0.5])))[0]
    assert 0.0 < edge < 1.0 and frame.rings[0] < 0.0 < frame.rings[1]


def test_an_axis_that_misses_the_planet_has_a_frame_too():
    away = moon(0.0)
    away = dataclasses.replace(away, center=np.array(away.center) + [0.0, 0.0, 1.2 * R])
    frame = shadow_frame(EARTH, SUN, away)
    assert np.allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-12) and frame.axes[2, 2] > 0.99
    assert np.all(np.isfinite(frame.up(np.linspace(0, 1, 20), np.linspace(0, 1, 20))))


def test_directions_turn_with_the_zenith(rng):
    frame = shadow_frame(EARTH, SUN, moon(40.0))
    up, a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(3, 200, 3)))
    up = np.where((up @ frame.axes[2] > -0.9)[:, None], up, -up)
    turned = frame.turn(up, a)
    assert np.allclose(np.linalg.norm(turned, axis=1), 1.0)
    assert np.allclose(np.sum(turned * frame.turn(up, b), axis=1), np.sum(a * b, axis=1))
    assert np.allclose(turned[:, 2], np.sum(a * up, axis=1)) and np.allclose(frame.turn(up, up), [0, 0, 1], atol=1e-12)
    assert np.allclose(frame.turn_back(up, turned), a)


def test_harmonics_of_all_azimuths_are_orthonormal():
    mu, weights = gauss_legendre(12)
    azimuth = 2 * np.pi * (np.arange(12) + 0.5) / 12
    values = zenith_harmonics(2 * mu - 1, 4)[:, None] * azimuth_harmonics(azimuth, 4)
    gram = np.einsum("i,iak,ial->kl", 2 * weights, values, values) * 2 * np.pi / 12
    assert gram.shape == (25, 25) and np.allclose(gram, np.eye(25), atol=1e-12)


def test_volume_is_zero_where_the_sun_is_whole(rng):
    """The same moments twice leave no ratio; others do, and darkness gives no NaN."""
    grid = RatioGrid(EARTH, SUN, moon(40.0, beside=4e7), SMALL)
    assert np.all(grid.visible == 1.0) and shade(1.0) == 1.0
    fields = rng.uniform(0.5, 1.0, (SMALL.heights, SMALL.columns, SMALL.coefficients + 1, 3))
    assert not np.any(grid.values(fields, fields))
    assert np.allclose(grid.values(fields, 0.5 * fields)[0], np.log(0.5))
    fields[0, 0] = 0.0
    assert np.all(np.isfinite(grid.values(fields, 0.0 * fields)))


class Volumes:
    """The passes up to the volumes of one scene, with small recipes."""

    def __init__(self, ctx, scene):
        self.table, self.eclipse = MultipleScattering(ctx, TABLE, "rgba32f"), Eclipse(ctx)
        self.ratio, self.textures = EclipseMultiple(ctx, SMALL, TABLE), {}
        with preserve_state(ctx):
            self.table.draw(scene.atmosphere, self.textures)
            self.eclipse.draw(scene, self.textures)
            self.ratio.draw(scene, self.textures)

    def release(self):
        for item in (self.table, self.eclipse, self.ratio):
            item.release()


def test_solve_agrees_with_twin(ctx):
    scene, _ = eclipse(40.0)
    volumes = Volumes(ctx, scene)
    texture = volumes.textures["ratio"][SUN]
    data = np.frombuffer(texture.read(), np.float32).reshape(SMALL.heights, SMALL.sectors, -1, SMALL.rings, 4)[..., :3]
    got = data.transpose(2, 0, 1, 3, 4)
    volumes.release()
    twin = solve_ratio(solve(EARTH, TABLE), SUN, scene.occluders[0], SMALL)
    dark = twin.grid.visible.reshape(twin.values.shape[1:4]) < 0.01
    assert dark.any() and not dark.all() and np.ptp(twin.values[0][dark]) > 1.0
    # a table of visible fractions in the shader, 1e-3 of full sunlight, counts where there is little light
    assert np.max(np.abs(got[0] - twin.values[0])) < 0.05 and np.median(np.abs(got[0] - twin.values[0])) < 5e-3
    shapes = np.abs(got[1:-1] - twin.values[1:-1])
    assert np.max(shapes) < 0.1 and np.median(shapes) < 3e-3 and np.max(np.abs(twin.values[1:-1])) > 0.3
    assert np.max(np.abs(got[-1, 0] - twin.values[-1, 0])) < 0.05


def test_lookup_agrees_with_twin(ctx, glsl, rng):
    scene, spot = eclipse(40.0)
    volumes = Volumes(ctx, scene)
    grid = RatioGrid(EARTH, SUN, scene.occluders[0], SMALL)
    shape = (SMALL.coefficients + 1, SMALL.heights, SMALL.sectors, SMALL.rings, 3)
    volume = RatioVolume(grid, SUN, scene.occluders[0], rng.normal(size=shape) * 0.05)
    rows = volume.values.transpose(1, 2, 0, 3, 4).reshape(SMALL.heights * SMALL.sectors, -1, 3)
    data = np.pad(rows, ((0, 0), (0, 0), (0, 1))).astype(np.float32)
    volumes.textures["ratio"][SUN].write(data.tobytes())
    count = 1000
    up = spot + 0.3 * rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    altitude = EARTH.thickness * rng.uniform(0, 1, count) ** 2
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = (R + altitude)[:, None] * up
    code = """
    vec3 point = in0.xyz;
    float visible = visible_fraction(point, 0);
    out0 = vec4(source_under(vec3(2.0e-5), vec3(1.0), densities(in1.w), point, in1.xyz, in1.w, 0, visible), visible);
    out1 = vec4(ground_ratio_under(normalize(point), 0, visible), 0.0);
    """
    defines, uniforms, samplers = ratio_inputs(scene, SUN, volumes.textures, SMALL)
    defines = {**defines, **medium_defines(EARTH), **multiple_defines(TABLE)}
    del defines["HAS_RATIO"], defines["HAS_ECLIPSE"]
    uniforms |= {**medium_uniforms(EARTH), **multiple_uniforms(EARTH)}
    samplers |= multiple_samplers(volumes.textures)
    inputs = [points, np.concatenate([directions, altitude[:, None]], axis=1)]
    got, ground = glsl(["eclipse_multiple.glsl"], code, inputs, uniforms, defines, outputs=2, samplers=samplers)
    volumes.release()
    visible = visible_fraction(points, SUN, scene.occluders[0])
    source = np.full((count, 3), 2e-5)
    expected = volume.source(points, directions, source, np.ones((count, 3)), densities(EARTH, altitude)[:, :2])
    both = shade(visible) / shade(got[:, 3])
    assert np.median(np.abs(both - 1.0)) < 1e-4
    # the table's angle about the axis is good to 2e-5, and textures are filtered with 8 bits of weight
    assert np.max(np.abs(got[:, :3] * both[:, None] / expected - 1.0)) < 3e-3
    assert np.std(np.log(expected / shade(visible)[:, None])) > 0.02
    ratio = volume.ground_ratio(R * up) / shade(visible_fraction(R * up, SUN, scene.occluders[0]))[:, None]
    assert np.max(np.abs(ground[:, :3] / shade(got[:, 3])[:, None] / ratio - 1.0)) < 3e-3


def errors(ctx, quality):
    """Return the errors of the reference cases beyond three standard errors of the Monte Carlo: rays, ground."""
    rays, ground = [], []
    for case, got in probed(ctx, "eclipse_multiple", quality):
        e = case["expected"]
        for found, name, value in ((rays, "multi", got["multiple"]), (ground, "ground_multi", got["ground_multiple"])):
            if name in e:
                want, noise = np.array(e[name]), np.array(e[name + "_se"])
                found.append(np.maximum(np.abs(value - want) - 3 * noise, 0.0) / want)
    return np.concatenate(rays), np.concatenate(ground)


def test_reference_cases(ctx):
    rays, ground = errors(ctx, "balanced")
    # asked for: 6 %, 24 %, 30 %; scaling by the visible fraction alone is 100 % off in totality
    assert len(rays) == 45 and np.median(rays) < 0.02 and np.percentile(rays, 95) < 0.05
    assert np.percentile(ground, 95) < 0.06


def light(ctx, scene, origin, directions, quality="balanced"):
    """Return the multiple light of rays from one point, (N, 3)."""
    directions = np.asarray(directions, float)
    return sa.probe(ctx, scene, np.tile(origin, (len(directions), 1)), directions, quality=quality)


def test_without_a_penumbra_in_the_air_nothing_changes(ctx):
    up = np.array([np.cos(0.8), np.sin(0.8), 0.0])
    rays = [up, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    plain = light(ctx, sa.Scene(suns=SUN), (R + 2.0) * up, rays).multiple
    # the penumbra dips 25 km into the air, far from the place; its axis leans outward by 25 km
    width = penumbra_cone(1.7374e6, SUN.radius, SUN.distance - 3.66e8).width(3.66e8)
    scene = sa.Scene(suns=SUN, occluders=sa.Occluder((3.66e8, 0.0, EARTH.top_radius + width - 5e4), 1.7374e6))
    assert shading_occluders(scene, SUN)
    assert np.allclose(light(ctx, scene, (R + 2.0) * up, rays).multiple, plain, rtol=1e-5)


def test_contact_is_continuous(ctx):
    """The moon moves over a fixed place, from outside through first contact into deep partial eclipse."""
    origin, rays = np.array([0.0, 0.0, R + 2.0]), [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 1.0, 0.05]]
    sun = sa.Sun(direction=(np.sin(0.7), 0.0, np.cos(0.7)))
    values, visible = [], []
    for step in np.linspace(4.2e6, 2.2e6, 9):
        center = 3.66e8 * np.array(sun.direction) + [0.0, step, R]
        scene = sa.Scene(suns=sun, occluders=sa.Occluder(center=center, radius=1.7374e6))
        values.append(light(ctx, scene, origin, rays).multiple)
        visible.append(visible_fraction(origin[None], sun, scene.occluders[0])[0])
    ratio = np.array(values) / light(ctx, sa.Scene(suns=sun), origin, rays).multiple
    assert visible[0] == 1.0 and visible[-1] < 0.9
    assert np.max(np.abs(ratio[0] - 1.0)) < 1e-3
    # light that has travelled knows of the shadow a little before and a little after the place itself
    assert np.max(np.abs(ratio - np.array(visible)[:, None, None])) < 0.1
    assert np.all(np.diff(ratio, axis=0) < 1e-4)
    assert np.max(np.abs(np.diff(ratio, n=2, axis=0))) < 0.06


def test_totality_has_a_dark_zenith_and_a_sunset_all_around(ctx):
    scene, up = eclipse(45.0)
    side = np.cross(up, [0.0, 0.0, 1.0])
    around = [np.cos(a) * side + np.sin(a) * np.array([0, 0, 1.0]) + 0.03 * up for a in np.arange(4) * np.pi / 2]
    rays = [up, *around]
    shaded, plain = (light(ctx, s, (R + 2.0) * up, rays) for s in (scene, sa.Scene(suns=SUN)))
    total, normal = (p.single + p.multiple for p in (shaded, plain))
    assert np.all(shaded.single[0] < 1e-2 * shaded.multiple[0])
    assert np.all((total[0] / normal[0] > 1e-4) & (total[0] / normal[0] < 1e-3))  # the literature's 3e-4
    assert np.all(total[1:, 0] / total[0, 0] > 20.0)
    # redder than the zenith on every side
    assert np.all(total[1:, 0] / total[1:, 2] > 2.0 * total[0, 0] / total[0, 2])


def test_moons_whose_discs_are_apart_add_up(ctx):
    """Far from each other's shadow both do what each does alone; where both shade a place what they take adds up."""
    first, second = moon(40.0, beside=-2.2e6), moon(40.0, beside=2.2e6)
    up = shadow_frame(EARTH, SUN, moon(40.0)).axes[2]
    rays = [up, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    plain, one, other, both = (
        light(ctx, sa.Scene(suns=SUN, occluders=o), (R + 2.0) * up, rays).multiple
        for o in ((), (first,), (second,), (first, second))
    )
    assert np.all(one / plain < 0.9) and np.all(other / plain < 0.9)
    assert np.allclose(both, one + other - plain, rtol=1e-3)
    # in totality of one, the other changes little and nothing turns negative
    up = shadow_frame(EARTH, SUN, first).axes[2]
    alone, both = (
        light(ctx, sa.Scene(suns=SUN, occluders=o), (R + 2.0) * up, rays).multiple
        for o in ((first,), (first, second))
    )
    assert np.all(both > 0.3 * alone) and np.all(both < 1.001 * alone)
    # a second moon right before the first takes nothing more
    twice = first, dataclasses.replace(first, center=np.array(first.center) * 1.0001)
    assert np.allclose(light(ctx, sa.Scene(suns=SUN, occluders=twice), (R + 2.0) * up, rays).multiple, alone, rtol=0.1)


@pytest.mark.parametrize(
    ("size", "distance", "off"), [(0.01, 58, 0.3), (3.0, 10, 1.05), (30.0, 3, 10.0), (300.0, 60, 50.0)]
)
def test_every_moon_takes_light_and_no_more_than_there_is(ctx, rng, size, distance, off):
    """Specks, grazing shadows and moons far larger than the planet, size in suns, distances in ground radii."""
    radius = distance * R * np.sin(size * SUN.radius / SUN.distance)
    scene = sa.Scene(suns=SUN, occluders=sa.Occluder((distance * R, min(off * R, 0.8 * R + radius), 0.0), radius))
    up, rays = rng.normal(size=(2, 60, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    origins = (R + EARTH.thickness * rng.uniform(0.0, 1.2, (60, 1)) ** 2) * up
    got, plain = (sa.probe(ctx, s, origins, rays, quality="balanced") for s in (scene, sa.Scene(suns=SUN)))
    for name in ("multiple", "ground_multiple"):
        shaded, full = getattr(got, name), getattr(plain, name)
        assert np.all(np.isfinite(shaded)) and np.all(shaded >= 0.0) and np.all(shaded <= 1.0001 * full)
    assert np.any(got.multiple < plain.multiple)


def test_no_moon_no_text():
    features = {"HAS_MULTIPLE": True, "HAS_AIR": True, "HAS_SEGMENTS": True, "HAS_MULTIPLE_VIEW": True}
    for name in ("probe.frag", "atmosphere.frag", "planet.frag"):
        assert "ratio" not in compose_source(name, features, optional=features).text.replace("ratios", "")
    features["HAS_RATIO"] = True
    assert "ratio" in compose_source("planet.frag", features, optional=features).text
