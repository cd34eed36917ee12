"""The sea: energy of the reflected sun, limits of Fresnel, the shader against the twin."""

import numpy as np
import pytest

from shadowatmo.water import NORMAL_REFLECTANCE, SLOPE_VARIANCE, fresnel, glint


def test_fresnel_at_its_ends():
    assert fresnel(1.0) == NORMAL_REFLECTANCE and fresnel(0.0) == 1.0


@pytest.mark.parametrize("zenith", [0.0, 30.0, 60.0])
def test_reflected_sun_keeps_its_energy(zenith):
    """Summed over the sky, what is reflected is what falls on the water times about the mirror's reflectance."""
    mu_s, sine = np.cos(np.radians(zenith)), np.sin(np.radians(zenith))
    mu = (np.arange(600) + 0.5) / 600
    azimuth = 2 * np.pi * (np.arange(720) + 0.5) / 720
    nu = mu[:, None] * mu_s + np.sqrt(1 - mu * mu)[:, None] * sine * np.cos(azimuth)
    total = np.sum(glint(mu[:, None], mu_s, nu) * mu[:, None]) * (2 * np.pi / 720) / 600
    # facets of other tilts reflect a little more or less than the flat mirror; single reflections only
    assert 0.9 * fresnel(mu_s) < total / mu_s < 1.6 * fresnel(mu_s)


def test_sun_is_brightest_where_the_mirror_shows_it():
    mu_s = np.cos(np.radians(50))
    angles = np.radians(np.arange(-80, 81, 1.0))  # of the eye in the sun's plane, positive away from the sun
    nu = np.cos(angles + np.radians(50))
    brightness = glint(np.cos(angles), mu_s, nu) * np.cos(angles)  # of the patch, not of its foreshortened surface
    assert 45 < np.degrees(angles[np.argmax(brightness)]) < 65
    assert brightness[0] < 1e-3 * brightness.max()


def test_shader_agrees_with_twin(glsl, rng):
    mu, mu_s = rng.uniform(0.01, 1, 500), rng.uniform(0.01, 1, 500)
    azimuth = rng.uniform(0, np.pi, 500)
    nu = mu * mu_s + np.sqrt((1 - mu**2) * (1 - mu_s**2)) * np.cos(azimuth)
    code = "out0 = vec4(glint(in0.x, in0.y, in0.z), fresnel(in0.x), SLOPE_VARIANCE, 0.0);"
    result = glsl(["water.glsl"], code, [np.stack([mu, mu_s, nu], axis=1)])
    truth = glint(mu, mu_s, nu)
    assert np.allclose(result[:, 0], truth, rtol=1e-3, atol=1e-6 * truth.max())
    assert np.allclose(result[:, 1], fresnel(mu), rtol=1e-5)
    assert np.isclose(result[0, 2], SLOPE_VARIANCE, rtol=1e-6)
