"""Depth conventions in float64: round trips over ten decades, and what means nothing."""

import numpy as np
import pytest

from shadowatmo.depth import CONVENTIONS, DepthConvention
from shadowatmo.errors import ParameterError

DISTANCES = np.logspace(0, 9, 40)


@pytest.mark.parametrize("kind", [c for c in CONVENTIONS if c != "position"])
@pytest.mark.parametrize("far", [2e9, np.inf])
def test_round_trip(kind, far):
    if kind == "logarithmic" and far == np.inf:
        far = 1e10
    convention = DepthConvention(kind, near=0.5, far=far, coefficient=0.01)
    stretch = np.linspace(1.0, 2.0, 40)
    distances = DISTANCES * stretch
    # a standard z-buffer squeezes 1e9 m into its last 1e-10: even float64 keeps 6 digits only
    rtol = 1e-5 if kind == "standard" else 1e-9
    assert np.allclose(convention.distance(convention.encode(distances, stretch), stretch), distances, rtol=rtol)
    assert convention.distance(convention.encode(np.inf)) == np.inf


def test_units():
    assert DepthConvention("distance", meters_per_unit=1000.0).distance(2.5) == 2500.0


def test_what_is_no_distance_is_nothing():
    for value in (np.nan, np.inf, -1.0):
        assert DepthConvention("linear").distance(value) == np.inf


def test_position_has_no_single_value():
    assert np.isclose(DepthConvention("position").distance([3.0, 4.0, 12.0]), 13.0)
    with pytest.raises(ParameterError, match="kind"):
        DepthConvention("position").encode(1.0)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"kind": "inverse"}, "kind"),
        ({"near": 0.0}, "near"),
        ({"near": np.nan}, "near"),
        ({"near": 1.0, "far": 0.5}, "far"),
        ({"kind": "logarithmic"}, "far"),
        ({"coefficient": -1.0}, "coefficient"),
        ({"meters_per_unit": 0.0}, "meters_per_unit"),
    ],
)
def test_bad_values(arguments, name):
    with pytest.raises(ParameterError) as caught:
        DepthConvention(**arguments)
    assert caught.value.name == name
