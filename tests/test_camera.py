"""The camera's pixel rays, as the contract words them."""

import math

import numpy as np
import pytest

import shadowatmo as sa


def test_pixel_rays_follow_the_definition():
    camera = sa.Camera(position=(7e6, 0, 0), target=(0, 1e6, 0), up=(0, 0, 1), vertical_fov=math.radians(40))
    width, height = 37, 21
    rays = camera.pixel_rays((width, height))
    forward = np.array([-7e6, 1e6, 0]) / np.hypot(7e6, 1e6)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up, t = np.cross(right, forward), math.tan(math.radians(20))
    for i, j in ((0, 0), (36, 0), (5, 20), (18, 10)):
        x, y = 2 * (i + 0.5) / width - 1, 1 - 2 * (j + 0.5) / height
        ray = forward + x * (width / height) * t * right + y * t * up
        assert np.allclose(rays[j, i], ray / np.linalg.norm(ray), atol=1e-14)
    assert rays[0, 0] @ up > 0 > rays[20, 0] @ up  # row 0 is the top


def test_up_parallel_to_forward_still_gives_a_rotation():
    basis = sa.Camera(position=(0, 0, 1e7), target=(0, 0, 0)).basis()
    assert np.allclose(basis @ basis.T, np.eye(3)) and np.isclose(np.linalg.det(basis), -1.0)


def test_right_up_forward_are_left_to_right_bottom_to_top():
    right, up, forward = sa.Camera(position=(1, 0, 0), forward=(0, 1, 0)).basis()
    assert np.allclose(right, [1, 0, 0]) and np.allclose(up, [0, 0, 1]) and np.allclose(forward, [0, 1, 0])


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"position": (math.nan, 0, 0), "forward": (1, 0, 0)}, "position"),
        ({"position": (0, 0), "forward": (1, 0, 0)}, "position"),
        ({"position": (1, 0, 0)}, "target"),
        ({"position": (1, 0, 0), "target": (0, 0, 0), "forward": (1, 0, 0)}, "target"),
        ({"position": (1, 0, 0), "target": (1, 0, 0)}, "target"),
        ({"position": (1, 0, 0), "forward": (0, 0, 0)}, "forward"),
        ({"position": (1, 0, 0), "forward": (1, 0, 0), "up": (0, 0, 0)}, "up"),
        ({"position": (1, 0, 0), "forward": (1, 0, 0), "vertical_fov": math.pi}, "vertical_fov"),
        ({"position": (1, 0, 0), "forward": (1, 0, 0), "vertical_fov": "60"}, "vertical_fov"),
        ({"position": (1, 0, 0), "forward": (1, 0, 0), "depth": "reversed"}, "depth"),
    ],
)
def test_bad_values(arguments, name):
    with pytest.raises(sa.ParameterError) as caught:
        sa.Camera(**arguments)
    assert caught.value.name == name


def test_from_a_view_matrix_of_pyrr():
    import pyrr

    eye, target = np.array([10.0, 6371.0, 3.0]), np.array([11.0, 6371.5, 3.5])
    view = pyrr.matrix44.create_look_at(eye, target, [0.0, 1.0, 0.0])
    camera = sa.Camera.from_view(
        view, 1.0, layout="row-vector", planet_center=(10.0, 0.0, 3.0), meters_per_unit=1000.0
    )
    want = sa.Camera(position=(0, 6.371e6, 0), forward=target - eye, up=(0, 1, 0), vertical_fov=1.0)
    assert np.allclose(camera.position, want.position, atol=1e-3)
    assert np.allclose(camera.basis(), want.basis(), atol=1e-6)
    same = sa.Camera.from_view(view.T, 1.0, layout="column-vector", planet_center=(10.0, 0.0, 3.0), meters_per_unit=1e3)
    assert np.allclose(same.position, camera.position)
    with pytest.raises(sa.ParameterError, match="layout"):
        sa.Camera.from_view(view, 1.0, layout="column-vector")
    with pytest.raises(sa.ParameterError, match="view"):
        sa.Camera.from_view(2 * view, 1.0, layout="row-vector")
    with pytest.raises(sa.ParameterError, match="view"):
        sa.Camera.from_view(np.full((4, 4), np.nan), 1.0, layout="row-vector")
