"""Rays: what is accepted, what it becomes, and what is refused by name."""

import numpy as np
import pytest

from shadowatmo.errors import ParameterError
from shadowatmo.rays import Rays


def test_single_vectors_make_one_ray():
    rays = Rays.validated((1.0, 2.0, 3.0), (0.0, 0.0, 5.0))
    assert len(rays) == 1
    assert rays.directions.tolist() == [[0.0, 0.0, 1.0]]
    assert rays.t_max.tolist() == [np.inf]


def test_no_rays_are_allowed():
    rays = Rays.validated(np.empty((0, 3)), np.empty((0, 3)))
    assert len(rays) == 0 and rays.t_max.shape == (0,)


@pytest.mark.parametrize("size", [1e-300, 1e-6, 1.0, 1e300])
def test_directions_of_any_length_are_normalized(size):
    rays = Rays.validated(np.zeros((2, 3)), size * np.array([[1.0, 2.0, 2.0], [-3.0, 0.0, 4.0]]))
    # two roundings of the root and the quotient
    assert np.allclose(rays.directions, [[1 / 3, 2 / 3, 2 / 3], [-0.6, 0.0, 0.8]], rtol=0, atol=3e-16)


def test_t_max_may_be_a_number_or_one_per_ray():
    origins, directions = np.zeros((2, 3)), np.ones((2, 3))
    assert Rays.validated(origins, directions, 7).t_max.tolist() == [7.0, 7.0]
    assert Rays.validated(origins, directions, [0.0, np.inf]).t_max.tolist() == [0.0, np.inf]


def test_later_changes_of_the_input_do_not_reach_the_rays():
    origins = np.zeros((1, 3))
    rays = Rays.validated(origins, (1.0, 0.0, 0.0))
    origins[0, 0] = 9.0
    assert rays.origins[0, 0] == 0.0


@pytest.mark.parametrize(
    ("name", "origins", "directions", "t_max"),
    [
        ("origins", [[np.nan, 0, 0]], [[1, 0, 0]], None),
        ("origins", [[np.inf, 0, 0]], [[1, 0, 0]], None),
        ("origins", [[0, 0]], [[1, 0]], None),
        ("origins", "here", [[1, 0, 0]], None),
        ("directions", [[0, 0, 0]], [[0, 0, 0]], None),
        ("directions", [[0, 0, 0]], [[1, np.nan, 0]], None),
        ("directions", [[0, 0, 0]], [[1, 0, 0], [0, 1, 0]], None),
        ("t_max", [[0, 0, 0]], [[1, 0, 0]], -1.0),
        ("t_max", [[0, 0, 0]], [[1, 0, 0]], np.nan),
        ("t_max", [[0, 0, 0]], [[1, 0, 0]], [1.0, 2.0]),
    ],
)
def test_malformed_rays_are_refused_by_name(name, origins, directions, t_max):
    with pytest.raises(ParameterError) as caught:
        Rays.validated(origins, directions, t_max)
    assert caught.value.name == name


def test_the_message_tells_which_ray_is_wrong():
    with pytest.raises(ParameterError, match="ray 2"):
        Rays.validated(np.zeros((3, 3)), [[1, 0, 0], [0, 1, 0], [0, 0, 0]])
