"""Densities and columns of the air against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from shadowatmo.medium import (
    altitude_from_power,
    densities,
    extinction,
    kink_altitudes,
    path_columns,
    scattering,
)
from shadowatmo.presets import EARTH, MARS

R = EARTH.bottom_radius
SHELL = EARTH.thickness * (2 * R + EARTH.thickness)


def to_top(altitude, elevation):
    """Power, slope and length of paths from `altitude` at `elevation` [rad] to the top of EARTH."""
    radius = R + altitude
    slope = radius * np.sin(elevation)
    power = altitude * (2 * R + altitude)
    return power, slope, np.sqrt(slope**2 + SHELL - power) - slope


def test_densities_follow_their_laws():
    h = np.array([0.0, 8000.0, 25e3, 32.5e3, 59e3])
    expected = np.stack([np.exp(-h / 8000), np.exp(-h / 1200), [0, 0, 1, 0.5, 0]], axis=1)
    assert np.allclose(densities(EARTH, h), expected, rtol=1e-14, atol=0)


def test_densities_end_at_the_top_and_stay_level_below_the_ground():
    assert densities(EARTH, 60e3 + 1e-6).tolist() == [0, 0, 0]
    assert densities(EARTH, -5.0).tolist() == densities(EARTH, 0.0).tolist() == [1, 1, 0]


def test_coefficients_are_the_atmosphere_s():
    assert extinction(EARTH)[1].tolist() == list(EARTH.mie_extinction)
    assert extinction(MARS)[2].tolist() == [0, 0, 0]
    assert scattering(EARTH)[1].tolist() == list(EARTH.mie_scattering)
    assert kink_altitudes(EARTH).tolist() == [10e3, 25e3, 40e3]
    assert kink_altitudes(MARS).size == 0


def test_altitude_from_power_does_not_cancel():
    h = np.array([1e-9, 1e-3, 1.0, 1e5])
    assert np.allclose(altitude_from_power(R, h * (2 * R + h)), h, rtol=1e-15, atol=0)


def test_vertical_columns_in_closed_form():
    h = np.array([0.0, 100.0, 12e3, 30e3, 59e3])
    columns = path_columns(EARTH, *to_top(h, np.pi / 2))
    for species, scale in enumerate((8000.0, 1200.0)):
        expected = scale * (np.exp(-h / scale) - np.exp(-60e3 / scale))
        # altitudes from slope = R carry an error of 1e-9 m; columns follow it by 1e-9/1200
        assert np.allclose(columns[:, species], expected, rtol=1e-11, atol=0)
    tent = [15e3, 15e3, 15e3 - 2e3**2 / 2 / 15e3, 10e3**2 / 2 / 15e3, 0.0]
    assert np.allclose(columns[:, 2], tent, rtol=1e-11, atol=1e-9)


def test_level_density_gives_the_length():
    level = replace(EARTH, rayleigh_scale_height=1e14, ozone=None)
    power, slope, length = to_top(np.array([0.0, 10.0, 20e3, 30e3]), np.array([0.0, 1.0, 0.01, -0.03]))
    # exp(-6e4/1e14) differs from 1 by 6e-10
    assert np.allclose(path_columns(level, power, slope, length)[:, 0], length, rtol=1e-9, atol=0)


def random_paths(count):
    """Paths to the top that do not meet the ground, most of them near the horizon."""
    rng = np.random.default_rng(5)
    altitude = EARTH.thickness * rng.uniform(0, 1, count) ** 3
    dip = np.arccos(R / (R + altitude))
    return to_top(altitude, np.maximum(rng.uniform(-1, 1, count) ** 5 * np.pi / 2, -dip))


@pytest.mark.parametrize("atmosphere", [EARTH, replace(EARTH, mie_scale_height=100.0)])
def test_columns_are_converged(atmosphere):
    paths = random_paths(500)
    coarse, fine = path_columns(atmosphere, *paths), path_columns(atmosphere, *paths, nodes=32)
    # measured 2e-14; the floor of 1e-9 m is the rounding of altitudes in thin aerosol
    assert np.allclose(coarse, fine, rtol=1e-12, atol=1e-9)
    assert not np.allclose(path_columns(atmosphere, *paths, nodes=2), fine, rtol=1e-6, atol=1e-9)


def test_columns_add_up_and_do_not_know_the_way():
    power, slope, length = random_paths(300)
    part = length * np.linspace(0.01, 0.99, 300)
    whole = path_columns(EARTH, power, slope, length)
    split = path_columns(EARTH, power, slope, part)
    split += path_columns(EARTH, power + part * (part + 2 * slope), slope + part, length - part)
    back = path_columns(EARTH, power + length * (length + 2 * slope), -(slope + length), length)
    assert np.allclose(split, whole, rtol=1e-11, atol=1e-8)
    assert np.allclose(back, whole, rtol=1e-11, atol=1e-8)
