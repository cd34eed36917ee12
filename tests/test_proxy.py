"""Proxy meshes cover their shapes from every side, closed, with their faces turned outward."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.proxy import cone_mesh, contains, sphere_mesh
from shadowatmo.shadow import cylinder, umbra_cone

R, TOP = sa.EARTH.bottom_radius, sa.EARTH.top_radius
AXIS = np.array([0.48, -0.6, 0.64])
MESHES = {
    "sphere": sphere_mesh(TOP),
    "cylinder": cone_mesh(cylinder(R), AXIS, TOP),
    "umbra": cone_mesh(umbra_cone(R, 6.957e8, 1.496e11), AXIS, TOP),
    "steep umbra": cone_mesh(umbra_cone(R, 30 * R, 40 * R), AXIS, TOP),
}


@pytest.mark.parametrize("name", MESHES)
def test_closed_and_outward(name):
    mesh = MESHES[name]
    volume = np.einsum("ij,ij->i", mesh[:, 0], np.cross(mesh[:, 1], mesh[:, 2])).sum() / 6
    area = np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]).sum(axis=0)
    assert volume > 0 and np.linalg.norm(area) < 1e-6 * abs(volume) ** (2 / 3)


def test_every_point_of_the_shapes_is_inside(rng):
    directions = rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert all(contains(MESHES["sphere"], p) for p in TOP * directions)
    assert not contains(MESHES["sphere"], 1.02 * TOP * directions[0])
    side = np.cross(AXIS, directions)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    for z in (0.0, 0.5 * R, 0.99 * TOP):
        assert all(contains(MESHES["cylinder"], z * AXIS + R * s) for s in side)
    assert not contains(MESHES["cylinder"], 0.5 * R * AXIS + 1.02 * R * side[0])


def test_rasterized_variant_stands_inside_its_shape():
    assert np.linalg.norm(sphere_mesh(TOP, circumscribed=False), axis=-1).max() <= TOP * (1 + 1e-12)
