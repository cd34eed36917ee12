"""Shadow cones along rays: the float64 twin against marching, the shader against the twin."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.constants import cone_uniforms
from shadowatmo.shadow import (
    ANTUMBRA,
    UMBRA,
    AxisRay,
    antumbra_cone,
    axis_ray,
    cone_interval,
    cylinder,
    penumbra_cone,
    umbra_cone,
)

R, RS, D = sa.EARTH.bottom_radius, 6.957e8, 1.496e11
# a small sun and a big sun make cones of every slope; the last one widens
CONES = {
    "cylinder": (cylinder(R), UMBRA),
    "umbra": (umbra_cone(R, RS, D), UMBRA),
    "penumbra": (penumbra_cone(R, RS, D), UMBRA),
    "steep umbra": (umbra_cone(R, 8 * R, 20 * R), UMBRA),
    "steep antumbra": (antumbra_cone(R, 8 * R, 20 * R), ANTUMBRA),
    "widening umbra": (umbra_cone(R, 0.2 * R, 20 * R), UMBRA),
}


def random_rays(rng, count):
    """Points within ten radii, directions in all classes: random, along and across the axis (which is z)."""
    points = rng.normal(size=(count, 3)) * R * rng.choice([0.5, 1.0, 3.0], (count, 1))
    directions = rng.normal(size=(count, 3))
    directions[: count // 4, :2] *= 1e-3
    directions[count // 4 : count // 2, 2] *= 1e-3
    return points, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def inside(cone, nappe, points):
    z, rho = points[..., 2], np.linalg.norm(points[..., :2], axis=-1)
    w = nappe * cone.width(z)
    return (z >= cone.near) & (z <= cone.far) & (rho <= w)


@pytest.mark.parametrize("name", CONES)
def test_twin_agrees_with_marching(rng, name):
    cone, nappe = CONES[name]
    points, directions = random_rays(rng, 400)
    axis = np.array([0.0, 0.0, 1.0])
    start, end = cone_interval(axis_ray(points, directions, axis, np.zeros(3), R), cone, nappe)
    reach = 40 * R
    t = (np.arange(8000) + 0.5) / 8000 * 2 * reach - reach
    marched = inside(cone, nappe, points[:, None] + t[:, None] * directions[:, None]).mean(axis=1) * 2 * reach
    closed = np.maximum(np.minimum(end, reach) - np.maximum(start, -reach), 0.0)
    assert np.max(np.abs(marched - closed)) < 2.1 * (2 * reach / 8000)  # a step at either end
    assert (marched > 0).sum() > 20


def test_twin_rejects_another_cone(rng):
    points, directions = random_rays(rng, 200)
    ray = axis_ray(points, directions, np.array([0.0, 0.0, 1.0]), np.zeros(3), R)
    a, b = cone_interval(ray, CONES["umbra"][0]), cone_interval(ray, CONES["penumbra"][0])
    met = a[0] < a[1]
    assert np.all(b[1][met] - b[0][met] > a[1][met] - a[0][met])


@pytest.mark.parametrize("name", CONES)
def test_shader_agrees_with_twin(glsl, rng, name):
    cone, nappe = CONES[name]
    points, directions = random_rays(rng, 1500)
    ray = axis_ray(points, directions, np.array([0.0, 0.0, 1.0]), np.zeros(3), R)
    code = """
      AxisRay ray = AxisRay(in0.x, in0.y, in0.z, in0.w, in1.x, in1.y);
      out0.xy = cone_interval(ray, u_test, in1.z);
    """
    inputs = [
        np.stack([ray.z, ray.dz, ray.across, ray.drift], axis=1),
        np.stack([ray.impact, ray.rim, np.full(1500, nappe)], axis=1),
    ]
    header = ["shadow.glsl"]
    glsl.folder.joinpath("uniform.glsl").write_text('#include "shadow.glsl"\nuniform Cone u_test;\n')
    result = glsl([*header, "uniform.glsl"], code, inputs, cone_uniforms("u_test", cone)).astype(float)
    truth = np.stack(cone_interval(ray, cone, nappe), axis=1)
    reach = 40 * R
    length = np.maximum(np.minimum(truth[:, 1], reach) - np.maximum(truth[:, 0], -reach), 0.0)
    got = np.maximum(np.minimum(result[:, 1], reach) - np.maximum(result[:, 0], -reach), 0.0)
    error = np.abs(got - length)
    assert np.isfinite(result[:, :2]).all()
    # 6e-8 of ten radii is 4 m; a ray that grazes a surface turns that into more, so the tail is bounded by percentiles
    assert np.percentile(error, 50) < 4.0
    assert np.percentile(error, 95) < 400.0
    assert np.mean((got > 0) != (length > 0)) < 2e-3


def test_camera_at_the_apex():
    cone = umbra_cone(R, RS, D)
    apex = np.array([[0.0, 0.0, cone.far]])
    back = np.array([[0.0, 0.0, -1.0]])
    start, end = cone_interval(axis_ray(apex, back, np.array([0.0, 0.0, 1.0]), np.zeros(3), R), cone)
    assert abs(start[0]) < 1.0 and abs(end[0] - (cone.far - cone.near)) < 1.0


def test_along_the_cylinder():
    ray = AxisRay(*(np.array(v) for v in ([0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [-1.0, 1.0])))
    start, end = cone_interval(ray, cylinder(R))
    assert start[0] == 0.0 and end[0] > 1e20
    assert start[1] >= end[1]
