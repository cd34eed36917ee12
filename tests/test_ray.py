"""Rays inside the air: the float64 forms against plain geometry, the shader's against the float64 forms."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.constants import air_uniforms
from shadowatmo.ray import altitude_of, ground_distance, k_along, k_of, make_ray, ray_from_points


def camera_rays(rng, altitude, count=400):
    """Random rays from one altitude that meet the air."""
    r = sa.EARTH.bottom_radius + altitude
    mu = np.clip(rng.uniform(-1, 1, count) ** 3, -1, 1)
    if altitude > sa.EARTH.thickness:
        mu = -np.sqrt(1 - (rng.uniform(0, 0.999, count) * sa.EARTH.top_radius / r) ** 2)
    directions = np.stack([np.sqrt(1 - mu * mu), np.zeros(count), mu], axis=1)
    return np.broadcast_to([0.0, 0.0, r], (count, 3)), directions


@pytest.mark.parametrize("altitude", [0.001, 2.0, 1e4, 4e5, 3.6e7, 1e9])
def test_twin_agrees_with_plain_geometry(rng, altitude):
    origins, directions = camera_rays(rng, altitude)
    ray = ray_from_points(sa.EARTH, origins, directions)
    exit_point = origins + (ray.start + ray.air)[:, None] * directions
    # float64 positions of 1e9 m have steps of 1e-7 m; grazing exits amplify them
    assert np.allclose(np.linalg.norm(exit_point, axis=1), sa.EARTH.top_radius, atol=2e-3)
    ground = ground_distance(ray)
    hits = (ground >= 0) & (ground <= ray.air)
    landed = origins + (ray.start + ground)[:, None] * directions
    assert np.allclose(np.linalg.norm(landed[hits], axis=1), sa.EARTH.bottom_radius, atol=2e-3)
    assert hits.any() and not hits.all()


def test_altitude_keeps_a_millimeter_where_radii_have_lost_it():
    k = k_of(sa.EARTH, np.array([1e-3, 2.0, 6e4]))
    assert np.allclose(altitude_of(sa.EARTH, k), [1e-3, 2.0, 6e4], rtol=1e-12)


def test_rays_that_miss():
    origins = np.array([[0, 0, 7e6], [0, 0, 7e6]], float)
    directions = np.array([[0, 0, 1], [1, 0, 0]], float)
    assert np.all(ray_from_points(sa.EARTH, origins, directions).air < 0)


# metres of error of a float32 ray whose inputs are exact: the exit of the shell, the ground, and the altitude midway;
# the first two grow where a grazing ray makes the length ill-conditioned
@pytest.mark.parametrize(
    ("altitude", "median", "worst"), [(2.0, 0.1, 3.0), (1e4, 0.2, 20.0), (4e5, 1.0, 100.0), (3.6e7, 8.0, 900.0)]
)
def test_shader_keeps_its_digits(glsl, rng, altitude, median, worst):
    origins, directions = camera_rays(rng, altitude)
    x = np.einsum("ij,ij->i", origins, directions)
    k = np.full(len(x), k_of(sa.EARTH, altitude))
    truth = ray_from_points(sa.EARTH, origins, directions)
    end = np.where(ground_distance(truth) >= 0, ground_distance(truth), truth.air)
    code = """
      Ray ray = make_ray(in0.x, in0.y, in0.z);
      out0 = vec4(ray.start, ray.air, ground_distance(ray), altitude_of(k_along(ray, in0.w)));
    """
    result = glsl(["ray.glsl"], code, [np.stack([x, k, truth.tangent_k, 0.5 * end], axis=1)], air_uniforms(sa.EARTH))
    exit_error = np.abs(result[:, 0] + result[:, 1] - truth.start - truth.air)
    assert np.median(exit_error) < median and exit_error.max() < worst
    assert np.array_equal(result[:, 2] >= 0, ground_distance(truth) >= 0)
    middle = altitude_of(sa.EARTH, k_along(truth, 0.5 * end))
    assert np.percentile(np.abs(result[:, 3] - middle), 90) < 0.5


def test_radii_in_place_of_k_would_not_pass(rng):
    """What the forms are for: the same arithmetic with radii is hundreds of metres wrong at the horizon."""
    origins, directions = camera_rays(rng, 2.0)
    truth = ray_from_points(sa.EARTH, origins, directions)
    r, mu = np.float32(sa.EARTH.bottom_radius + 2.0), directions[:, 2].astype(np.float32)
    x = r * mu
    naive = -x - np.sqrt(np.maximum(x * x - (r * r - np.float32(sa.EARTH.bottom_radius) ** 2), 0))
    hits = ground_distance(truth) >= 0
    assert np.max(np.abs(naive[hits] - ground_distance(truth)[hits])) > 10.0


def test_below_the_ground_the_ground_is_at_once():
    ray = make_ray(sa.EARTH, np.array([-10.0, 10.0]), k_of(sa.EARTH, -1.0) * np.ones(2), np.full(2, -2e7))
    assert ground_distance(ray)[0] == 0.0 and ground_distance(ray)[1] < 0.0
