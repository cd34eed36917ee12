"""The fisheye: every pixel of the disc shows its own direction of the sky."""

import math

import numpy as np
import pytest

from shadowatmo.fisheye import EDGE, bilinear, disc_directions, face_cameras, resample
from shadowatmo.places import local_axes

POSITION = (3e6, -4e6, 3e6)


def test_the_picture_of_directions_is_right():
    """Faces that hold the directions they see give the disc's own, but for the bend between two of their pixels."""
    n, size = 181, (120, 91)
    faces = [camera.pixel_rays((n, n)) @ local_axes(POSITION).T for camera in face_cameras(POSITION)]
    seen, wanted = resample(faces, size), disc_directions(size)
    inside = np.isfinite(wanted[..., 0])
    error = np.linalg.norm(seen - np.nan_to_num(wanted), axis=-1)
    # at a seam the outermost half pixel of a face, 0.5 / n, is that of its last pixel's middle
    assert error[inside].max() < 0.6 / n * math.pi / 2 and np.median(error[inside]) < 1e-4
    assert not seen[~inside].any()
    turned = resample([*faces[:1], *faces[2:], faces[1]], size)
    assert np.abs(turned - seen).max() > 0.5


def test_north_is_at_the_top_and_east_on_the_left():
    toward = disc_directions((101, 101))
    assert toward[50, 50] == pytest.approx((0, 0, 1), abs=1e-9)
    assert toward[5, 50, 1] > 0.9 and toward[95, 50, 1] < -0.9
    assert toward[50, 5, 0] > 0.9 and toward[50, 95, 0] < -0.9
    assert np.isnan(toward[0, 0]).all()


def test_the_distance_from_the_middle_is_the_angle():
    angle = np.arccos(disc_directions((200, 100))[49, 100:150, 2])
    away = np.hypot(np.arange(50) + 0.5, 0.5)  # pixels
    assert angle == pytest.approx(EDGE * away / 50, abs=1e-7)


def test_faces_see_a_half_cube():
    cameras = face_cameras(POSITION)
    up = np.array(POSITION) / np.linalg.norm(POSITION)
    assert [round(float(up @ camera.basis()[2]), 9) for camera in cameras] == [1, 0, 0, 0, 0]
    assert all(camera.vertical_fov == math.pi / 2 for camera in cameras)


def test_bilinear():
    ramp = np.arange(4.0)[None, :, None] + 10.0 * np.arange(4.0)[:, None, None] + np.zeros(3)
    assert bilinear(ramp, np.array([0.0]), np.array([0.0]))[0, 0] == pytest.approx(16.5)
    assert bilinear(ramp, np.array([1.0, -1.0]), np.array([-1.0, 1.0]))[:, 0] == pytest.approx((33.0, 0.0))
    assert bilinear(np.full((1, 1, 3), 7.0), np.array([0.3]), np.array([-0.9]))[0] == pytest.approx((7, 7, 7))
