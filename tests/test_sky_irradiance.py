"""Skylight on the ground: the row of irradiances against a converged sum over the twin's sky."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.passes.sky_irradiance import TEXELS, SkyIrradiance, irradiance_mapping


def texel_heights(atmosphere):
    """Return mu_s at the texel centers (the mapping of sky_irradiance.glsl)."""
    width, lowest = irradiance_mapping(atmosphere)["u_irradiance_mapping"]
    u = np.linspace(np.arcsinh(lowest / width), np.arcsinh(1 / width), TEXELS)
    return np.minimum(width * np.sinh(u), 1.0)


def true_irradiance(atmosphere, mu_s, directions=(24, 24)):
    """Return the irradiance (3,) of the ground by singly scattered light, by the float64 twin."""
    nodes, weights = np.polynomial.legendre.leggauss(directions[0])
    nodes, weights = 0.5 * (nodes + 1), 0.5 * weights
    mu, weight = nodes**2, weights * 2 * nodes * nodes**2
    azimuth = np.pi * (np.arange(directions[1]) + 0.5) / directions[1]
    sine = np.sqrt(1 - mu * mu)[:, None]
    upward = np.broadcast_to(mu[:, None], (len(mu), len(azimuth)))
    rays = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), upward], axis=-1)
    sun = sa.Sun(direction=(np.sqrt(1 - mu_s * mu_s), 0, mu_s))
    origins = np.tile([0, 0, atmosphere.bottom_radius], (rays[..., 0].size, 1))
    light = reference.probe(sa.Scene(atmosphere, sun), origins, rays.reshape(-1, 3)).single.reshape(*rays.shape)
    return np.einsum("i,ijc->c", weight, light) * 2 * np.pi / directions[1]


@pytest.mark.parametrize(("air", "tolerance"), [(sa.EARTH, 0.03), (sa.MARS, 0.03)])
def test_row_against_the_twin(ctx, air, tolerance):
    sky = SkyIrradiance(ctx)
    try:
        sky.draw(air, {})
        row = sky.target.read_color(0)[0, :, :3].astype(float)
    finally:
        sky.release()
    assert np.isfinite(row).all() and (row >= 0).all()
    heights = texel_heights(air)
    for texel in (TEXELS - 1, 50, 36, 26):
        truth = true_irradiance(air, heights[texel])
        # 8 x 8 directions resolve the aureole and the glow of a low sun to percents
        assert np.max(np.abs(row[texel] / truth - 1)) < tolerance, heights[texel]
    assert row[0].max() < 1e-3 * row[-1].max()  # deep night is dark
    assert np.all(np.diff(row[20:, 2]) > 0)  # the blue of the sky grows with the sun's height
