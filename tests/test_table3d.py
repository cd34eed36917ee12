"""The 3D tables: mappings, texels and lookups against the float64 twin, and what they lack."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.passes.constants import air_uniforms
from shadowatmo.passes.table3d import ELEK, SCHAFHITZEL, Table3D, table3d_defines, table3d_sizes, table3d_uniforms
from shadowatmo.passes.table_build import TableEffort, inscatter_samplers
from shadowatmo.phase import mie_phase, rayleigh_phase
from shadowatmo.quality import Quality
from shadowatmo.ray import ground_distance
from shadowatmo.table3d import (
    Table3DSize,
    ad_hoc_phase,
    inscatter_path,
    inscatter_place,
    single_scattering,
    sun_axis,
    sun_of_axis,
    texel_paths,
    texel_places,
)
from tests.table_rays import cut_rays, looks_down, make_rays, relative_errors, scatter_rays, true_single

LINEAR = Table3DSize(16, 32, 24)
CURVED = Table3DSize(12, 32, 16, "curved")
CLEAR = dataclasses.replace(sa.EARTH, ozone=None)
SHADOW = {"HAS_SHADOW": True, "HAS_TWO_PIECES": True}


@pytest.fixture
def tables(ctx):
    """Makes tables, and releases them after the test."""
    made = []

    def make(atmosphere, dimensions, **options):
        made.append(Table3D(ctx, dimensions, **{"table_format": "rgba32f", **options}))
        made[-1].draw(atmosphere, {})
        return made[-1]

    yield make
    for table in made:
        table.release()


def render(glsl, table, atmosphere, rays, features=None):
    """Radiance and transmittance of rays by a table."""
    defines = table3d_defines(atmosphere, Quality(terms=6), table.dimensions, table.orders) | (features or {})
    uniforms = table3d_uniforms(atmosphere, table.dimensions)
    return scatter_rays(glsl, "table3d.glsl", *rays, uniforms, defines, inscatter_samplers(table.textures))


def random_texels(rng, size, count):
    return np.stack([rng.integers(0, n, count) for n in size.texels], axis=1)


@pytest.mark.parametrize("mapping", ["linear", "curved"])
def test_mapping_round_trip(rng, mapping):
    place = rng.uniform(0, 1, (400, 3))
    paths = inscatter_path(sa.EARTH, place, mapping, azimuth=0.7)
    back = inscatter_place(sa.EARTH, paths.ray.k, paths.ray.x, paths.sun_height, mapping)
    assert np.allclose(back, place, atol=1e-9)
    other = "curved" if mapping == "linear" else "linear"
    wrong = inscatter_place(sa.EARTH, paths.ray.k, paths.ray.x, paths.sun_height, other)
    assert not np.allclose(wrong, place, atol=1e-2)


def test_published_places():
    # Elek 2009, section 4.1.1, at its ends; the lowest sun is the root of its exponential
    assert np.allclose(sun_axis(np.array([1.0, -0.8 / 2.8, -1.0]), "curved"), [1.0, 0.0, 0.0], atol=1e-12)
    assert np.isclose(sun_of_axis(0.0, "curved"), -0.8 / 2.8)
    assert np.allclose(sun_axis(np.array([1.0, 0.0, -1.0]), "linear"), [1.0, 0.5, 0.0])
    assert SCHAFHITZEL == Table3DSize(128, 128, 128, "linear") and ELEK == Table3DSize(32, 256, 32, "curved")


@pytest.mark.parametrize("size", [LINEAR, CURVED, Table3DSize(7, 16, 8)], ids=["linear", "curved", "prime"])
def test_shader_mapping_against_twin(glsl, rng, size):
    texel = random_texels(rng, size, 400)
    paths = texel_paths(sa.EARTH, size, texel)
    code = """
      TablePath path = inscatter_texel(ivec2(in0.xy));
      out0 = vec4(path.ray.k, path.ray.x, path.end, path.ground ? 1.0 : 0.0);
      TableCell cell = inscatter_at(path.ray.k, path.ray.x, path.sun, path.ray.tangent_k, path.ground);
      out1 = vec4(path.sun, mix(cell.low, cell.high, round(cell.part)) * TILE * TILES);
    """
    defines = {**table3d_sizes(size), **({"HAS_CURVED_MAPPING": True} if size.mapping == "curved" else {})}
    uniforms = {**air_uniforms(sa.EARTH), "u_sun_azimuth": 1.0}
    first, second = glsl(["table3d_mapping.glsl"], code, [texel], uniforms, defines, outputs=2)
    radius = sa.EARTH.bottom_radius
    assert np.allclose(first[:, 0], paths.ray.k, rtol=1e-5, atol=10.0)
    assert np.allclose(first[:, 1], paths.ray.x, atol=2e-6 * radius)
    assert np.array_equal(first[:, 3] > 0.5, paths.ground)
    assert np.allclose(first[:, 2], paths.end, atol=1e-4 * radius)  # a grazing path loses half of its digits
    assert np.allclose(second[:, 0], paths.sun_height, atol=2e-6 * radius)
    assert np.allclose(second[:, 1], paths.nu, atol=1e-3)
    assert np.allclose(second[:, 2:], texel + 0.5, atol=0.02)


def test_texels_cover_the_table_once():
    for size in (LINEAR, CURVED, SCHAFHITZEL, ELEK, Table3DSize(7, 4, 4)):
        columns, rows = np.meshgrid(*(np.arange(n) for n in size.texels))
        places = texel_places(size, np.stack([columns.ravel(), rows.ravel()], axis=1))
        assert len(places) == size.heights * size.views * size.suns == len(np.unique(places.round(9), axis=0))


def test_twin_against_reference(rng):
    """In the plane of the sun, and lit all along, a texel is what the reference says."""
    size = Table3DSize(16, 32, 24, azimuth=0.0)
    texel = random_texels(rng, size, 80)
    paths = texel_paths(CLEAR, size, texel)
    rayleigh, mie = single_scattering(CLEAR, paths)
    r = np.sqrt(CLEAR.bottom_radius**2 + paths.ray.k)
    mu, mu_s = paths.ray.x / r, paths.sun_height / r
    far_sun = paths.sun_height + paths.nu * paths.end  # above the terminator at both ends of the path
    lit = (mu_s > 0.05) & (far_sun > 0) & (paths.end > 100.0) & (paths.ray.k > 0)
    checked = 0
    for i in np.flatnonzero(lit):
        direction = [np.sqrt(1 - mu[i] ** 2), 0.0, mu[i]]
        sun = sa.Sun(direction=(np.sqrt(1 - mu_s[i] ** 2), 0.0, mu_s[i]))
        truth = reference.probe(sa.Scene(atmosphere=CLEAR, suns=sun), [0, 0, r[i] * (1 - 1e-12)], direction).single[0]
        ours = rayleigh_phase(paths.nu[i]) * rayleigh[i] + mie_phase(paths.nu[i], CLEAR.mie_g) * mie[i]
        assert np.allclose(ours, truth, rtol=1e-3)  # the closed form of the columns
        checked += 1
    assert checked > 15


@pytest.mark.parametrize("size", [LINEAR, CURVED], ids=["linear", "curved"])
def test_texels_against_twin(tables, rng, size):
    table = tables(sa.EARTH, size)
    texel = random_texels(rng, size, 500)
    for number, twin in enumerate(single_scattering(sa.EARTH, texel_paths(sa.EARTH, size, texel))):
        got = table.stored[0].read_color(number)[texel[:, 1], texel[:, 0], :3]
        error = np.abs(got - twin) / np.maximum(twin, 1e-4 * twin.max())
        # 12 nodes a path, and float32; paths that graze the ground may end on it or not
        assert np.percentile(error, 50) < 1e-4 and np.percentile(error, 95) < 2e-2


@pytest.mark.parametrize("size", [Table3DSize(64, 128, 64), ELEK], ids=["linear", "curved"])
def test_day_rays_against_reference(tables, glsl, rng, size):
    table = tables(sa.EARTH, size, table_format="rgba16f")
    rays = make_rays(sa.EARTH, rng, "ground, day", 120)
    cut, truth = cut_rays(sa.EARTH, *rays), true_single(sa.EARTH, *rays)
    radiance, transmittance = render(glsl, table, sa.EARTH, cut)
    up = ~looks_down(cut[0])
    error = relative_errors(radiance, truth)[up]
    assert np.nanmedian(error) < 0.005 and np.nanpercentile(error, 90) < 0.05
    assert np.max(np.abs(transmittance - reference.probe(sa.Scene(), *rays[:2]).transmittance)) < 1e-3


def test_terrain_cut(tables, glsl, rng):
    """Two lookups: the rest of the path behind the terrain is taken away."""
    table = tables(sa.EARTH, Table3DSize(32, 128, 32, "curved"))
    rays = make_rays(sa.EARTH, rng, "terrain cut", 120)
    cut, truth = cut_rays(sa.EARTH, *rays), true_single(sa.EARTH, *rays)
    up = ~looks_down(cut[0])
    error = relative_errors(render(glsl, table, sa.EARTH, cut)[0], truth)[up]
    assert np.nanmedian(error) < 0.02
    open_rays = cut_rays(sa.EARTH, *rays[:3], np.full(120, np.inf))
    uncut = relative_errors(render(glsl, table, sa.EARTH, open_rays)[0], truth)[up]
    assert np.nanmedian(uncut) > 0.1


def test_the_cone_gives_the_shadow_that_the_table_lacks(tables, glsl, rng):
    table = tables(sa.EARTH, Table3DSize(32, 64, 64, "curved"))
    rays = make_rays(sa.EARTH, rng, "ground, twilight", 100)
    ray, sun, cuts = cut_rays(sa.EARTH, *rays)
    truth = true_single(sa.EARTH, *rays)
    away = sun[:, 1] < 0  # towards the shadow
    with_cuts = render(glsl, table, sa.EARTH, (ray, sun, cuts), SHADOW)[0]
    without = render(glsl, table, sa.EARTH, (ray, sun, cuts))[0]
    size = truth[away].max()
    assert np.mean(np.abs(with_cuts - truth)[away]) < 0.5 * np.mean(np.abs(without - truth)[away])
    # the fault that stays: without azimuth a cut piece still is not the truth
    assert np.mean(np.abs(with_cuts - truth)[away]) > 0.01 * size
    dark = cuts[:, 2] - cuts[:, 1] > 0.999 * cuts[:, 3]
    assert not dark.any() or with_cuts[dark].max() < 1e-6


def test_one_lit_piece_is_the_general_case(tables, glsl, rng):
    table = tables(sa.EARTH, CURVED)
    ray, sun, cuts = cut_rays(sa.EARTH, *make_rays(sa.EARTH, rng, "ground, twilight", 200))
    single = (cuts[:, 1] <= 0) | (cuts[:, 2] >= cuts[:, 3])
    one = render(glsl, table, sa.EARTH, (ray, sun, cuts), {"HAS_SHADOW": True})
    two = render(glsl, table, sa.EARTH, (ray, sun, cuts), SHADOW)
    assert single.sum() > 50
    assert np.allclose(one[0][single], two[0][single], rtol=1e-4, atol=1e-9)
    assert np.allclose(one[1], two[1], atol=1e-6)


def test_doubling_every_axis_cuts_the_error(tables, glsl, rng):
    rays = make_rays(sa.EARTH, rng, "ground, day", 80)
    cut, truth = cut_rays(sa.EARTH, *rays), true_single(sa.EARTH, *rays)
    up = ~looks_down(cut[0])
    for mapping, start in (("linear", 16), ("curved", 8)):
        errors = []
        for scale in (1, 2, 4):
            size = Table3DSize(*(start * scale,) * 3, mapping)
            radiance = render(glsl, tables(sa.EARTH, size), sa.EARTH, cut)[0]
            errors.append(np.nanmedian(relative_errors(radiance, truth)[up]))
        # down to what the missing azimuth leaves
        assert errors[1] < 0.6 * errors[0] and errors[2] < 0.7 * errors[1]


def test_shares_of_orders_fall_geometrically(tables):
    sums = [tables(sa.EARTH, CURVED, orders=k).stored[0].read_color(0)[..., :3] for k in range(1, 7)]
    sums = [values.mean(axis=(0, 1), dtype=float) for values in sums]
    shares = np.diff(sums, axis=0)
    ratios = shares[1:] / shares[:-1]
    assert (shares > 0).all() and (ratios < 0.7).all()
    assert np.max(np.abs(ratios[-1] / ratios[-2] - 1)) < 0.05


def test_ad_hoc_phase(glsl, rng):
    nu = rng.uniform(-1, 1, 200)
    defines = {"HAS_AD_HOC_PHASE": True, **table3d_sizes(CURVED)}
    got = glsl(["table3d_mapping.glsl"], "out0.x = ad_hoc_phase(in0.x);", [nu], defines=defines)
    assert np.allclose(got[:, 0], ad_hoc_phase(nu), rtol=1e-6)
    assert np.isclose(4 * np.pi * ad_hoc_phase(0.0), 1.12)
    # darkest opposite the sun, where the true one is as bright as ahead
    assert ad_hoc_phase(-1.0) < ad_hoc_phase(nu).min()
    assert np.isclose(rayleigh_phase(-1.0), rayleigh_phase(1.0))


def test_ambient_light(tables, rng):
    """The row of irradiances is the sum over the sky of what the table holds: checked by plain Monte Carlo."""
    table = tables(CLEAR, CURVED, effort=TableEffort(sky=24))
    row = table.irradiance.read_color(0)[0, :, :3]
    texel = 230
    mu_s = sun_of_axis(texel / 255, "curved")
    mu, azimuth = np.sqrt(rng.uniform(0, 1, 400)), rng.uniform(0, 2 * np.pi, 400)  # by the cosine: the mean is E / pi
    sine = np.sqrt(1 - mu**2)
    origins = np.broadcast_to([0.0, 0.0, CLEAR.bottom_radius], (400, 3))
    directions = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), mu], axis=1)
    sun = sa.Sun(direction=(np.sqrt(1 - mu_s**2), 0, mu_s))
    ours = reference.probe(sa.Scene(atmosphere=CLEAR, suns=sun), origins, directions).single.mean(axis=0) * np.pi
    # 400 samples of a sky with an aureole, and this table's coarse cells
    assert np.allclose(row[texel], ours, rtol=0.15)
    assert (np.diff(row.sum(axis=1)) > -1e-6).all()  # more sun, more light


def test_more_orders_brighten_the_ambient(tables):
    one, six = (tables(sa.EARTH, CURVED, orders=k).irradiance.read_color(0)[0, :, :3] for k in (1, 6))
    assert (six[128:] > one[128:]).all()
    assert (six[200:] < 3 * one[200:]).all()


def test_nothing_is_not_finite(tables):
    for air in (sa.EARTH, sa.MARS):
        for size, orders in ((LINEAR, 1), (CURVED, 3)):
            table = tables(air, size, orders=orders)
            stored = table.stored[0]
            for values in (stored.read_color(0), stored.read_color(1), table.irradiance.read_color(0)):
                assert np.isfinite(values).all() and (values >= 0).all()


@pytest.mark.parametrize(
    "bad", [{"heights": 1}, {"mapping": "cubic"}, {"azimuth": 4.0}, {"suns": 2.0}], ids=lambda b: next(iter(b))
)
def test_bad_sizes(bad):
    with pytest.raises(sa.ParameterError, match=next(iter(bad))):
        Table3DSize(**bad)


def test_paths_end_where_the_air_does(rng):
    paths = texel_paths(sa.EARTH, LINEAR, random_texels(rng, LINEAR, 300))
    assert np.array_equal(paths.ground, ground_distance(paths.ray) >= 0) and (paths.end >= 0).all()
