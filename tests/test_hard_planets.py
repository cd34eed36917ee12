"""Planets of extreme sizes and shells of extreme depths against the float64 twin."""

from dataclasses import replace

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.extremes import (
    closed_form_holds,
    has_curved_ozone,
    has_dense_top,
    has_opaque_ozone,
    is_deep,
    is_small,
    is_thick,
)
from shadowatmo.segments import nodes_for
from tests.hard_cases import NO_OZONE, Case, check_air, check_small_changes

E = sa.EARTH
R = E.bottom_radius
NEUTRAL = (3e-5, 3e-5, 3e-5)


def times(factor, values):
    return tuple(factor * np.array(values))


def scaled(radius):
    """The Earth as a model of another radius: all lengths, and so the optical depths, in proportion."""
    s = radius / R
    return sa.Atmosphere(
        bottom_radius=radius,
        top_radius=radius + E.thickness * s,
        rayleigh_scattering=times(1 / s, E.rayleigh_scattering),
        rayleigh_scale_height=8e3 * s,
        mie_scattering=times(1 / s, E.mie_scattering),
        mie_extinction=times(1 / s, E.mie_extinction),
        mie_scale_height=1.2e3 * s,
        mie_g=E.mie_g,
        ozone=sa.TentLayer(25e3 * s, 15e3 * s, times(1 / s, E.ozone.extinction)),
    )


def resized(radius):
    """The Earth's air, as it is, on a planet of another radius."""
    return replace(E, bottom_radius=radius, top_radius=radius + E.thickness)


def shell(thickness, height, mie_height):
    """A shell of another depth around the Earth, its layers, were they infinite, of the Earth's optical depths."""
    return sa.Atmosphere(
        bottom_radius=R,
        top_radius=R + thickness,
        rayleigh_scattering=times(8e3 / height, E.rayleigh_scattering),
        rayleigh_scale_height=height,
        mie_scattering=times(1.2e3 / mie_height, E.mie_scattering),
        mie_extinction=times(1.2e3 / mie_height, E.mie_extinction),
        mie_scale_height=mie_height,
        mie_g=E.mie_g,
    )


CASES = {
    "radius 10 m": Case(scaled(10.0)),
    "radius 10 km": Case(scaled(1e4)),
    "radius 70 000 km": Case(scaled(7e7)),
    "radius 1e9 m": Case(scaled(1e9)),
    "radius 10 m, the Earth's air": Case(
        resized(10.0), smooth=3e-4, reason="float32 tells the height of a ray over a ball of 10 m to 2e-7 of itself"
    ),
    "radius 10 km, the Earth's air": Case(resized(1e4), light=NO_OZONE),
    "radius 70 000 km, the Earth's air": Case(
        resized(7e7),
        light=4e-3,
        smooth=5e-5,
        reason="ozone of optical depth 3 along the horizon: 30 nodes resolve its kinks to 3e-3",
    ),
    "radius 1e9 m, the Earth's air": Case(
        resized(1e9),
        2e-4,
        3e-3,
        1.5e-3,
        reason="float32 tells the ozone's ends to 64 m of 15 km; it is 10 deep along the horizon",
    ),
    "shell of 1e-4 radii": Case(shell(1e-4 * R, 80.0, 12.0), light=NO_OZONE),
    "shell of 1e-4 radii, tall layers": Case(shell(1e-4 * R, 8e3, 1.2e3), light=NO_OZONE),
    "shell of 10 radii, low layers": Case(
        shell(10 * R, 8e3, 1.2e3), 5e-4, 2e-3, 3e-3, "on a ray of 64 000 km float32 tells the ground to 8 m of 1.2 km"
    ),
    "shell of 10 radii, tall layers": Case(shell(10 * R, R, 0.2 * R), light=NO_OZONE),
    "shell of 10 radii, taller layers": Case(shell(10 * R, 5 * R, R), light=NO_OZONE),
    "scale height above the shell's depth": Case(
        shell(6e4, 1e6, 1.2e3), 4e-4, NO_OZONE, reason="one map for layers of 60 km and 1.2 km, by 12 nodes in the dark"
    ),
    "both scale heights above it": Case(shell(6e4, 1e6, 3e5), light=NO_OZONE),
    "air of one density": Case(shell(6e4, 1e9, 1e8), light=NO_OZONE),
}


@pytest.mark.parametrize("name", CASES)
def test_planets(ctx, name):
    check_air(ctx, CASES[name])


@pytest.mark.parametrize("name", CASES)
def test_planets_that_change_a_little(ctx, name):
    check_small_changes(ctx, CASES[name])


def test_usual_airs_pay_for_nothing():
    """None of the presets asks for what extremes need, and the extremes do."""
    for air in (sa.EARTH, sa.MARS, sa.TITAN, sa.TOY_PLANET, sa.THIN_EARTH, sa.DENSE_EARTH):
        assert closed_form_holds(air) and not is_deep(air) and not is_thick(air) and not has_curved_ozone(air)
        assert not is_small(air) and not has_dense_top(air) and not has_opaque_ozone(air)
    assert not closed_form_holds(resized(10.0)) and not closed_form_holds(shell(6e4, 1e6, 1.2e3))
    assert is_deep(shell(10 * R, 8e3, 1.2e3)) and is_thick(resized(1e9)) and has_curved_ozone(resized(1e4))
    assert is_small(resized(10.0)) and has_opaque_ozone(resized(1e9))
    assert has_dense_top(replace(E, rayleigh_scattering=times(1e3, NEUTRAL)))
    assert nodes_for(sa.EARTH, 8) == 8 and nodes_for(resized(7e7), 8) == 12
