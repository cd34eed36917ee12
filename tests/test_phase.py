"""Phase functions: normalization, mean cosine, and the narrow forward peak."""

from fractions import Fraction

import numpy as np
import pytest

from shadowatmo.phase import mie_phase, rayleigh_phase

NODES, WEIGHTS = np.polynomial.legendre.leggauss(2000)


@pytest.mark.parametrize("g", [-0.9, 0.0, 0.5, 0.8, 0.99])
def test_mie_is_normalized(g):
    # 2000 nodes resolve the peak of g = 0.99 (width 1e-4 in nu) to rounding
    assert 2 * np.pi * WEIGHTS @ mie_phase(NODES, g) == pytest.approx(1.0, abs=1e-9)


def test_rayleigh_is_normalized_and_even():
    assert 2 * np.pi * WEIGHTS @ rayleigh_phase(NODES) == pytest.approx(1.0, abs=1e-12)
    assert rayleigh_phase(0.3) == rayleigh_phase(-0.3)


def test_mie_without_asymmetry_is_rayleigh():
    nu = np.linspace(-1, 1, 11)
    assert np.allclose(mie_phase(nu, 0.0), rayleigh_phase(nu), rtol=1e-15, atol=0)


@pytest.mark.parametrize("g", [0.6, 0.8])
def test_mean_cosine_of_cornette_shanks(g):
    # Cornette and Shanks 1992, equation 9: the mean cosine is 3 g (4 + g^2)/(5 (2 + g^2))
    mean = 2 * np.pi * WEIGHTS @ (NODES * mie_phase(NODES, g))
    assert mean == pytest.approx(3 * g * (4 + g * g) / (5 * (2 + g * g)), rel=1e-9)
    assert mean != pytest.approx(g, rel=1e-2)  # Henyey and Greenstein's would be g


@pytest.mark.parametrize("g", [0.8, 0.99, -0.99])
@pytest.mark.parametrize("off", [0.0, 2.0**-50, 2.0**-30, 2.0**-10])
def test_peak_keeps_its_digits(g, off):
    nu = 1.0 - off if g > 0 else off - 1.0
    exact_g, exact_nu = Fraction(g), Fraction(nu)
    base = 1 + exact_g**2 - 2 * exact_g * exact_nu
    expected = (
        3 / (8 * np.pi) * float((1 - exact_g**2) * (1 + exact_nu**2) / (2 + exact_g**2)) / float(base) ** 1.5
    )
    # a few roundings; 1 - g^2 and (1 - |g|)^2 carry the largest, amplified by 1.5
    assert mie_phase(nu, g) == pytest.approx(expected, rel=2e-14)


def test_mie_mirrors_with_the_sign_of_g():
    nu = np.linspace(-1, 1, 21)
    assert np.allclose(mie_phase(nu, 0.7), mie_phase(-nu, -0.7), rtol=1e-15, atol=0)
