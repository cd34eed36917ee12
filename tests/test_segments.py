"""Single scattering over lit pieces: the method's own error, and the shader against the twin."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.passes.constants import medium_defines, medium_uniforms, segment_defines, segment_uniforms
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.quality import Quality
from shadowatmo.ray import ground_distance, ray_from_points
from shadowatmo.segments import make_map, map_node, scatter
from shadowatmo.shadow import axis_ray, cone_interval, cylinder


def test_cumulative_matrix_integrates_polynomials():
    for count in (2, 5, 8, 16, 24):
        nodes, weights = gauss_legendre(count)
        matrix = cumulative_matrix(count)
        for power in range(count):
            # the interpolant of a polynomial below the count's degree is that polynomial
            assert np.allclose(matrix @ nodes**power, nodes ** (power + 1) / (power + 1), atol=1e-13)
            assert np.isclose(weights @ nodes**power, 1 / (power + 1), atol=1e-13)
    nodes = gauss_legendre(5)[0]
    assert not np.allclose(cumulative_matrix(5) @ nodes**5, nodes**6 / 6, atol=1e-13)  # one degree too many


def lit_paths(rng, count=250, altitude=2.0):
    """Rays from one altitude under a sun at 85 to 100 degrees, with their cuts: ray, sun height and cosine, cuts."""
    r = sa.EARTH.bottom_radius + altitude
    directions = rng.normal(size=(count, 3))
    directions[:, 2] = np.abs(directions[:, 2]) * rng.choice([0.05, 1.0], count)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = np.broadcast_to([0.0, 0.0, r], (count, 3))
    zenith = np.radians(rng.uniform(85, 100, count))
    suns = np.stack([np.sin(zenith), np.zeros(count), np.cos(zenith)], axis=1)
    ray = ray_from_points(sa.EARTH, origins, directions)
    end = np.where(ground_distance(ray) >= 0, ground_distance(ray), ray.air)
    cuts = np.zeros((count, 4))
    for i in range(count):
        axis = axis_ray(origins[i : i + 1], directions[i : i + 1], -suns[i], np.zeros(3), sa.EARTH.bottom_radius)
        start, stop = cone_interval(axis, cylinder(sa.EARTH.bottom_radius))
        dark = np.clip(start[0], 0.0, end[i])
        cuts[i] = 0.0, dark, np.clip(stop[0], dark, end[i]), end[i]
    heights, cosines = np.einsum("ij,ij->i", origins, suns), np.einsum("ij,ij->i", directions, suns)
    return ray, heights, cosines, cuts, (origins, directions, suns)


def test_method_converges_to_the_reference(rng):
    ray, heights, cosines, cuts, (origins, directions, suns) = lit_paths(rng, 60)
    truth = np.concatenate([
        reference.probe(sa.Scene(suns=sa.Sun(direction=suns[i])), origins[i], directions[i]).single for i in range(60)
    ])  # fmt: skip
    errors = []
    for nodes in (4, 8, 16):
        _, radiance = scatter(sa.EARTH, ray, heights, cosines, cuts, nodes, nodes)
        errors.append(np.percentile(np.abs(radiance - truth) / np.maximum(truth, 1e-4 * truth.max()), 95))
    # the closed form's own error (2e-5 in optical depth) is the floor
    assert errors[0] > 3 * errors[1] and errors[1] > errors[2] and errors[2] < 1e-3


@pytest.mark.parametrize("altitude", [2.0, 1e4])
def test_shader_agrees_with_twin(glsl, rng, altitude):
    ray, heights, cosines, cuts, _ = lit_paths(rng, altitude=altitude)
    quality = Quality(nodes=8, gap_nodes=4, terms=6)
    defines = {"TERMS": 6, "HAS_TOP": True, "HAS_SHADOW": True, "HAS_TWO_PIECES": True}
    defines |= {**medium_defines(sa.EARTH), **segment_defines(quality)}
    code = """
      Ray ray = Ray(in0.x, in0.y, in0.z, 0.0, in0.w);
      Scattered air = scatter(ray, in1.xy, in1.z, in2);
      out0 = vec4(air.radiance, 0.0);
      out1 = vec4(air.transmittance, 0.0);
    """
    inputs = [
        np.stack([ray.x, ray.k, ray.tangent_k, ray.air], axis=1),
        np.stack([heights, cosines, 1 - cosines**2], axis=1),
        cuts,
    ]
    uniforms = {**medium_uniforms(sa.EARTH), **segment_uniforms(sa.EARTH)}
    radiance, transmittance = glsl(["segments.glsl"], code, inputs, uniforms, defines, outputs=2)
    clear, light = scatter(sa.EARTH, ray, heights, cosines, cuts, 8, 4)
    error = np.abs(radiance[:, :3] - light) / np.maximum(light, 1e-4 * light.max())
    assert np.percentile(error, 99) < 1e-3  # float32, with altitudes to a few centimetres
    assert np.max(np.abs(transmittance[:, :3] - clear)) < 2e-4


def test_one_lit_piece_on_either_side_of_the_shadow(glsl, rng):
    """The shader for one lit piece equals the general one wherever there is only one."""
    ray, heights, cosines, cuts, _ = lit_paths(rng, 400, altitude=1e4)
    shadowed = (cuts[:, 2] > cuts[:, 1]) & ((cuts[:, 1] <= 0) | (cuts[:, 2] >= cuts[:, 3]))
    assert shadowed.sum() > 30
    quality = Quality()
    defines = {"TERMS": 4, "HAS_SHADOW": True, **medium_defines(sa.EARTH), **segment_defines(quality)}
    code = """
      Ray ray = Ray(in0.x, in0.y, in0.z, 0.0, in0.w);
      Scattered air = scatter(ray, in1.xy, in1.z, in2);
      out0 = vec4(air.radiance, 0.0);
      out1 = vec4(air.transmittance, 0.0);
    """
    inputs = [
        np.stack([ray.x, ray.k, ray.tangent_k, ray.air], axis=1)[shadowed],
        np.stack([heights, cosines, 1 - cosines**2], axis=1)[shadowed],
        cuts[shadowed],
    ]
    uniforms = {**medium_uniforms(sa.EARTH), **segment_uniforms(sa.EARTH)}
    one = glsl(["segments.glsl"], code, inputs, uniforms, defines, outputs=2)
    both = glsl(["segments.glsl"], code, inputs, uniforms, {**defines, "HAS_TWO_PIECES": True}, outputs=2)
    assert np.allclose(one[0], both[0], rtol=1e-4, atol=1e-9)
    assert np.allclose(one[1], both[1], atol=1e-5)


def test_map_covers_its_piece(rng):
    ray, *_, cuts, _ = lit_paths(rng, 50)
    sinh_map = make_map(sa.EARTH, ray, cuts[:, 0], cuts[:, 3])
    t, _ = map_node(sinh_map, np.array([0.0, 1.0]))
    assert np.allclose(t[:, 0], cuts[:, 0], atol=1e-5) and np.allclose(t[:, 1], cuts[:, 3], rtol=1e-9)
