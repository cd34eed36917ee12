"""From radiance to display values: exposure, curve, transfer function, dither."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.tonemap import Tonemap, automatic_exposure, check_exposure


def displayed(ctx, radiance, exposure):
    """Return 8-bit values (h, w, 3) of a linear picture (h, w, 3)."""
    height, width, _ = radiance.shape
    pixels = np.dstack([radiance, np.ones((height, width))]).astype(np.float32)
    color = ctx.texture((width, height), 4, pixels.tobytes(), dtype="f4")
    tonemap = Tonemap(ctx, (width, height))
    try:
        tonemap.draw({"color": color}, exposure)
        return tonemap.target.read_color(0)[..., :3] * 255.0
    finally:
        tonemap.release()
        color.release()


def test_curve_and_transfer_function(ctx):
    linear = np.array([0.0, 1e-4, 1e-3, 0.01, 0.1, 0.5, 2.0, 50.0])
    values = displayed(ctx, np.repeat(linear[None, :, None], 3, axis=2), 1.0)[0, :, 0]
    level = 1 - np.exp(-linear)
    want = 255 * np.where(level <= 0.0031308, 12.92 * level, 1.055 * level ** (1 / 2.4) - 0.055)
    assert np.max(np.abs(values - want)) <= 1.0  # half a step of dither, half of rounding


def test_dither_hides_steps(ctx):
    """A ramp of two 8-bit steps over 400 pixels shows no wide plateau, and keeps its mean."""
    ramp = np.linspace(0.2, 0.206, 400)
    values = displayed(ctx, np.repeat(np.repeat(ramp[None, :, None], 40, axis=0), 3, axis=2), 1.0)[..., 0]
    means = values.mean(axis=0)
    smooth = np.convolve(means, np.ones(40) / 40, "valid")
    assert np.all(np.diff(smooth) > -0.02)
    assert np.max(np.abs(np.diff(smooth))) < 0.1


def test_black_stays_black(ctx):
    assert displayed(ctx, np.zeros((8, 8, 3)), 5.0).max() <= 1.0


def test_automatic_exposure_ignores_space_and_glare(rng):
    picture = np.zeros((50, 80, 3))
    picture[:25] = 0.05
    base = automatic_exposure(picture)
    picture[10:12, 10:12] = 2e4  # a sun
    assert np.isclose(automatic_exposure(picture), base, rtol=0.05)
    assert np.isclose(automatic_exposure(10 * picture), base / 10, rtol=0.05)
    assert automatic_exposure(np.zeros((4, 4, 3))) == 1.0


@pytest.mark.parametrize("exposure", [0.0, -1.0, np.nan, np.inf, "bright"])
def test_bad_exposure(exposure):
    with pytest.raises(sa.ParameterError, match="exposure"):
        check_exposure(exposure)
