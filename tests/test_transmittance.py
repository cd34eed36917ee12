"""Columns towards the sun: closed form against quadrature, shader against twin, table against both."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.medium import path_columns
from shadowatmo.passes.constants import medium_defines, medium_uniforms
from shadowatmo.passes.transmittance import TransmittanceTable
from shadowatmo.ray import altitude_of, k_of
from shadowatmo.transmittance import columns_to_top, table_coordinates, table_point, transmittance_to_top

TOY = sa.Atmosphere(
    bottom_radius=1e4, top_radius=1.2e4, rayleigh_scattering=(5e-4, 1e-3, 2e-3), rayleigh_scale_height=400.0,
    mie_scattering=(9e-4,) * 3, mie_extinction=(1e-3,) * 3, mie_scale_height=150.0, mie_g=0.76,
)  # fmt: skip
AIRS = {"earth": sa.EARTH, "mars": sa.MARS, "toy": TOY}


def sun_rays(atmosphere, rng, count=600):
    """Points in the air and suns above their horizon: k, y."""
    altitude = atmosphere.thickness * rng.uniform(0, 0.95, count) ** 2
    k = k_of(atmosphere, altitude)
    horizon = -np.sqrt(k) / (atmosphere.bottom_radius + altitude)
    mu = horizon + (1 - horizon) * rng.uniform(0, 1, count) ** 2
    return k, mu * (atmosphere.bottom_radius + altitude)


def true_columns(atmosphere, k, y):
    top_k = k_of(atmosphere, atmosphere.thickness)
    return path_columns(atmosphere, k, y, np.sqrt(y * y + top_k - k) - y)


# terms, air -> largest error of the optical depth relative to itself; 1/X is 1/25 on the toy planet
@pytest.mark.parametrize(
    ("terms", "air", "tolerance"),
    [(6, "earth", 1e-4), (6, "mars", 1e-4), (6, "toy", 3e-3), (4, "earth", 2e-3), (4, "toy", 4e-3)],
)
def test_closed_form_against_quadrature(rng, terms, air, tolerance):
    atmosphere = AIRS[air]
    k, y = sun_rays(atmosphere, rng)
    closed, truth = columns_to_top(atmosphere, k, y, terms), true_columns(atmosphere, k, y)
    thick = truth[:, :2] > 1e-3 * truth[:, :2].max(axis=0)
    assert np.max(np.abs(closed[:, :2] / truth[:, :2] - 1)[thick]) < tolerance
    assert np.allclose(closed[:, 2], truth[:, 2], atol=max(1.0, 5e-4 * truth[:, 2].max()))


def test_infinite_top_is_not_the_top(rng):
    """The rejected case: without the column beyond the top the toy planet's transmittance is percents wrong."""
    k, y = sun_rays(TOY, rng)
    right = np.exp(-true_columns(TOY, k, y)[:, 0] * 2e-3)
    clear = dataclasses.replace(TOY, mie_scattering=(0, 0, 0), mie_extinction=(0, 0, 0))
    wrong = transmittance_to_top(clear, k, y, 6, False)
    assert np.max(np.abs(wrong[:, 2] - right)) > 0.01


@pytest.mark.parametrize("air", AIRS)
@pytest.mark.parametrize("terms", [4, 6])
def test_shader_agrees_with_twin(glsl, rng, air, terms):
    atmosphere = AIRS[air]
    k, y = sun_rays(atmosphere, rng)
    defines = {"TERMS": terms, "HAS_TOP": True, **medium_defines(atmosphere)}
    code = "out0 = vec4(columns_to_top(in0.x, in0.y), 0.0); out1 = vec4(transmittance_to_top(in0.x, in0.y), 0.0);"
    columns, transmittance = glsl(
        ["transmittance.glsl"], code, [np.stack([k, y], axis=1)], medium_uniforms(atmosphere), defines, outputs=2
    )
    twin = columns_to_top(atmosphere, k, y, terms)
    assert np.allclose(columns[:, :3], twin, rtol=3e-5, atol=1e-4 * twin.max(axis=0))
    # float32 through an exponent of a few tens, and altitudes to a few centimetres
    assert np.max(np.abs(transmittance[:, :3] - transmittance_to_top(atmosphere, k, y, terms))) < 3e-5


@pytest.mark.parametrize("air", AIRS)
def test_table_mapping_round_trip(rng, air):
    atmosphere, size = AIRS[air], (256, 64)
    texel = np.stack([rng.integers(0, 255, 300) + 0.5, rng.integers(1, 63, 300) + 0.5], axis=1)
    k, y = table_point(atmosphere, texel, size)
    assert np.allclose(table_coordinates(atmosphere, k, y, size) * size, texel, atol=1e-6)
    assert np.all(y >= -np.sqrt(k) * (1 + 1e-9))


@pytest.mark.parametrize("air", AIRS)
def test_table_texels_against_quadrature(ctx, air):
    atmosphere = AIRS[air]
    table = TransmittanceTable(ctx)
    try:
        table.draw(atmosphere, {})
        columns = table.target.read_color(0)[..., :3].astype(float)
    finally:
        table.release()
    assert np.isfinite(columns).all() and (columns >= 0).all()
    rows, texels = np.mgrid[0:60:7, 0:256:15]
    texel = np.stack([texels.ravel() + 0.5, rows.ravel() + 0.5], axis=1)
    k, y = table_point(atmosphere, texel, (256, 64))
    truth = true_columns(atmosphere, k, y)
    got = columns[rows.ravel(), texels.ravel()]
    # altitudes to a few centimetres of a scale height; the tent's sides straight over k, which is worth 2e-4 in optical
    # depth where the ray has its tangent point inside the layer
    assert np.allclose(got[:, :2], truth[:, :2], rtol=2e-4, atol=1e-4 * truth[:, :2].max(axis=0))
    assert np.max(np.abs(got[:, 2] - truth[:, 2])) <= 2e-4 / 1.881e-6


def test_table_is_drawn_once_per_air(ctx):
    table = TransmittanceTable(ctx)
    try:
        table.draw(sa.EARTH, {})
        earth = table.target.read_color(0).copy()
        table.draw(sa.MARS, {})
        assert not np.allclose(table.target.read_color(0), earth)
        table.draw(sa.EARTH, {})
        assert np.array_equal(table.target.read_color(0), earth)
    finally:
        table.release()


def test_altitudes_of_table_rows_start_on_the_ground():
    k, _ = table_point(sa.EARTH, [[0.5, 0.5], [0.5, 63.5]], (256, 64))
    assert np.allclose(altitude_of(sa.EARTH, k), [0.0, sa.EARTH.thickness])
