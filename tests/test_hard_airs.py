"""Airs of extreme density, without one species or another, with extreme phase functions, against the float64 twin."""

from dataclasses import replace

import numpy as np
import pytest

import shadowatmo as sa
from tests.hard_cases import NO_OZONE, SUNS, Case, check_air, check_small_changes, shell_fan

E = sa.EARTH
NONE = (0.0, 0.0, 0.0)


def of_depth(tau):
    """The Earth's air without ozone, made thicker or thinner: vertical optical depth `tau` in the blue."""
    factor = tau / (E.rayleigh_scattering[2] * E.rayleigh_scale_height + E.mie_extinction[2] * E.mie_scale_height)
    names = ("rayleigh_scattering", "mie_scattering", "mie_extinction")
    return replace(E, ozone=None, **{name: tuple(factor * np.array(getattr(E, name))) for name in names})


THICK = "30 nodes for all that lies before an optical depth of 16; the ground behind one of 7 is 1.2e-3 off"
CASES = {
    "optical depth 1e-8": Case(of_depth(1e-8), light=NO_OZONE),
    "optical depth 1": Case(of_depth(1.0), light=NO_OZONE),
    "optical depth 10": Case(of_depth(10.0), reason=THICK),
    "optical depth 100": Case(of_depth(100.0), light=NO_OZONE, reason=THICK),
    "optical depth 1e4": Case(
        of_depth(1e4),
        light=4e-3,
        reason="a low sun lights the uppermost 0.2 m of the air alone, which float32 tells to 5 mm",
    ),
    "no molecules": Case(replace(E, rayleigh_scattering=NONE), light=NO_OZONE),
    "no aerosols": Case(replace(E, mie_scattering=NONE, mie_extinction=NONE)),
    "aerosols that only absorb": Case(replace(E, mie_scattering=NONE)),
    "no ozone": Case(replace(E, ozone=None), light=NO_OZONE),
    "ozone of no extinction": Case(replace(E, ozone=sa.TentLayer(25e3, 15e3, NONE)), light=NO_OZONE),
    "ozone alone": Case(replace(E, rayleigh_scattering=NONE, mie_scattering=NONE, mie_extinction=NONE)),
    "nothing": Case(
        replace(E, rayleigh_scattering=NONE, mie_scattering=NONE, mie_extinction=NONE, ozone=None), light=NO_OZONE
    ),
    "g = -0.99": Case(replace(E, mie_g=-0.99, ozone=None), light=NO_OZONE),
    "g = 0": Case(replace(E, mie_g=0.0)),
    "g = 0.99": Case(replace(E, mie_g=0.99, ozone=None), light=NO_OZONE),
}


@pytest.mark.parametrize("name", CASES)
def test_airs(ctx, name):
    check_air(ctx, CASES[name])


@pytest.mark.parametrize("name", CASES)
def test_airs_that_change_a_little(ctx, name):
    check_small_changes(ctx, CASES[name])


@pytest.mark.parametrize(
    "name", ["optical depth 1e-8", "optical depth 100", "optical depth 1e4", "nothing", "g = 0.99"]
)
def test_multiple_scattering_is_bounded(ctx, name):
    """All orders: finite, not negative, and no more light than a white, endless cloud under the zenith sun sends.

    That is 5 / (4 pi): 3 / (4 pi) mu (mu + 2/3) deep inside, in Eddington's approximation. Within 25 degrees of the
    forward and backward peaks of an extreme phase function there may be more.
    """
    air = CASES[name].air
    for sun in SUNS.values():
        origins, directions, _ = shell_fan(air, sun)
        found = sa.probe(ctx, sa.Scene(air, sa.Sun(sun)), origins, directions, quality="balanced")
        for light in (found.multiple, found.ground_multiple):
            assert np.isfinite(light).all() and (light >= 0.0).all()
        aside = np.abs(directions @ sun) < 0.9
        assert found.multiple[aside].max() < 5.0 / (4.0 * np.pi)
        # the ground's share: its albedo of what reaches it, more than the sun's irradiance only by what it sends up
        assert (found.ground_direct + found.ground_multiple).max() < 0.1 / np.pi / (1.0 - 0.1)
        if name == "nothing":
            assert found.multiple.max() == 0.0 and found.single.max() == 0.0
        if name == "optical depth 1e-8":
            assert found.multiple.max() < 1e-6  # of the order of the ground's light times the depth along the horizon
        if name == "optical depth 100":
            bright = found.multiple[
                (np.abs(directions[:, 0]) > 0.3) & (origins[:, 0] > air.top_radius) & (found.end == "ground")
            ]
            assert sun[0] < 0.9 or bright.max() > 0.05  # and it is a bright cloud, not a dark one
