"""The visible fraction of the sun against ring-by-ring integration, closed forms and limits."""

import numpy as np
import pytest

from shadowatmo.eclipse import disc_visibility, joint_visibility, sun_visibility, visible_fraction
from shadowatmo.errors import ParameterError
from shadowatmo.parameters import Occluder, Sun
from shadowatmo.presets import EARTH
from shadowatmo.scene import Scene

SUN = Sun((1, 0, 0), limb_darkening=0.6)
MOON = Occluder((3.8e8, 0, 0), 1.7374e6)
X, W = np.polynomial.legendre.leggauss(400)
RING = np.sin(np.pi / 4 * (X + 1)) ** 2  # square roots at both ends of the range of radii
RING_WEIGHT = W * np.pi / 2 * np.sin(np.pi / 4 * (X + 1)) * np.cos(np.pi / 4 * (X + 1))


def by_rings(k, delta, u):
    """Visible fraction from the covered part of rings around the sun's center."""
    low, high = min(abs(k - delta), 1.0), min(1.0, k + delta)
    r = low + (high - low) * RING
    cosine = (r * r + (delta - k) * (delta + k)) / (2 * r * delta)
    intensity = 1 - u * (1 - np.sqrt(1 - r * r))
    covered = (high - low) * RING_WEIGHT @ (2 * np.arccos(np.clip(cosine, -1, 1)) * r * intensity)
    if k > delta:
        covered += np.pi * ((1 - u) * low**2 + u * 2 / 3 * (1 - (1 - low**2) ** 1.5))
    return 1 - covered / (np.pi * (1 - u / 3))


def overlaps():
    """Pairs k, delta: every kind of overlap, with gaps to the contacts down to 1e-12."""
    rng = np.random.default_rng(2)
    for _ in range(150):
        k = 10 ** rng.uniform(-2, np.log10(300))
        gap = 10 ** rng.uniform(-12, -2)
        yield k, rng.uniform(abs(k - 1), k + 1)
        yield k, (k + 1) - gap
        yield k, abs(k - 1) + gap
        if k < 1:
            yield k, (1 - k) * (1 - gap)
            yield k, (1 - k) * rng.uniform(0.001, 1)


@pytest.mark.parametrize("u", [0.0, 0.6, 1.0])
def test_fraction_agrees_with_rings(u):
    cases = np.array(list(overlaps()))
    expected = np.array([by_rings(k, delta, u) for k, delta in cases])
    error = np.abs(disc_visibility(cases[:, 0], cases[:, 1], u) - expected)
    assert error.max() < 1e-7  # that of the rings where two of their kinks nearly meet
    assert np.median(error) < 1e-12


@pytest.mark.parametrize("u", [0.0, 0.6, 1.0])
def test_fraction_is_converged(u):
    k, delta = np.array(list(overlaps())).T
    change = np.abs(disc_visibility(k, delta, u) - disc_visibility(k, delta, u, nodes=200))
    assert change.max() < 1e-8
    assert np.abs(disc_visibility(k, delta, u, nodes=3) - disc_visibility(k, delta, u)).max() > 1e-5


def test_uniform_annulus_in_closed_form():
    k = np.array([0.01, 0.3, 0.9])
    assert np.allclose(disc_visibility(k, 0.0, 0.0), 1 - k**2, rtol=0, atol=1e-14)
    # limb-darkened: the hidden light within r is pi ((1 - u) r^2 + u 2/3 (1 - (1 - r^2)^1.5))
    hidden = (0.4 * k**2 + 0.4 * (1 - (1 - k**2) ** 1.5)) / 0.8
    assert np.allclose(disc_visibility(k, 0.0, 0.6), 1 - hidden, rtol=0, atol=1e-14)


def test_limits_are_exact():
    assert disc_visibility(2.0, 1.0, 0.6) == 0.0
    assert disc_visibility(0.5, 1.5, 0.6) == 1.0
    assert disc_visibility(np.inf, 1.0, 0.6) == 0.0


def test_places_that_nothing_hides():
    behind_sun = Occluder((3e11, 0, 0), 1e9)
    origin = np.zeros((1, 3))
    assert visible_fraction(origin, SUN, behind_sun) == 1.0
    assert visible_fraction([[7e8, 0, 0]], SUN, MOON) == 1.0  # the moon is behind the point
    assert visible_fraction([MOON.center], SUN, MOON) == 0.0
    assert visible_fraction(origin, SUN, Occluder((3.8e8, 0, 0), 2.5e6)) == 0.0
    assert 0.0 < visible_fraction(origin, SUN, MOON) < 0.2


def test_fraction_changes_at_the_edges_of_the_cones():
    # outer cone of the moon at the plane x = 0: radius R / cos psi + z tan psi
    psi = np.arcsin((SUN.radius + MOON.radius) / (SUN.distance - 3.8e8))
    edge = MOON.radius / np.cos(psi) + 3.8e8 * np.tan(psi)
    inside, outside = visible_fraction([[0, edge - 10, 0], [0, edge + 1e-3, 0]], SUN, MOON)
    assert outside == 1.0
    assert 0.0 < 1 - inside < 1e-4


def test_two_occluders_that_do_not_overlap_add_up():
    # the discs are 0.0183 rad apart about the sun's center, each of 0.5 of its radius: no overlap
    pair = (Occluder((3.8e8, 1.1e6, 0), 0.5e6), Occluder((3.8e8, -1.1e6, 0), 0.5e6))
    points = np.array([[0.0, 0, 0], [0, 2e5, 3e4], [0, -1e6, 0]])
    parts = [visible_fraction(points, SUN, body) for body in pair]
    # ring quadrature against arcs; both are better than 1e-8
    assert np.allclose(joint_visibility(points, SUN, pair), parts[0] + parts[1] - 1, rtol=0, atol=1e-8)


def test_an_occluder_hidden_by_another_changes_nothing():
    points = np.array([[0.0, 0, 0], [0, 1e6, 0], [0, 2e6, 1e6]])
    pair = (MOON, Occluder((7.6e8, 0, 0), 1.0e6))  # half as large, behind the moon at first
    result = joint_visibility(points, SUN, pair)
    assert result[0] == pytest.approx(visible_fraction(points[:1], SUN, MOON)[0], abs=1e-8)
    each = np.stack([visible_fraction(points, SUN, body) for body in pair])
    assert np.all(result <= each.min(axis=0) + 1e-8)
    assert np.all(result >= each.sum(axis=0) - 1 - 1e-8)


def test_union_against_counting():
    pair = (Occluder((3.8e8, 0.9e6, 0), 1.2e6), Occluder((3.9e8, -0.3e6, 0.8e6), 0.9e6))
    n = 1500
    grid = (np.arange(n) + 0.5) / n * 2 - 1
    y, z = np.meshgrid(grid, grid)
    r2 = y * y + z * z
    scale = np.arcsin(SUN.radius / SUN.distance)
    intensity = np.where(r2 < 1, 1 - 0.6 * (1 - np.sqrt(np.maximum(1 - r2, 0))), 0)
    free = np.ones_like(r2, dtype=bool)
    for body in pair:
        center = np.array(body.center)
        distance = np.linalg.norm(center)
        angle = np.arctan2(np.hypot(*center[1:]), center[0]) / scale / np.hypot(*center[1:])
        free &= (
            np.hypot(y - center[1] * angle, z - center[2] * angle) > np.arcsin(body.radius / distance) / scale
        )
    counted = (intensity * free).sum() / intensity.sum()
    result = joint_visibility(np.zeros((1, 3)), SUN, pair)[0]
    assert result == pytest.approx(
        counted, abs=1e-4
    )  # 1500^2 cells: limbs of 5 n cells, errors cancel at random
    product = np.prod([visible_fraction(np.zeros((1, 3)), SUN, body)[0] for body in pair])
    assert abs(product - counted) > 1e-2  # what a mere product of the two would give


def test_sun_visibility_of_a_scene():
    scene = Scene(EARTH, SUN, MOON)
    points = np.array([[0.0, 0, 0], [0, 3e6, 0]])
    assert np.array_equal(sun_visibility(scene, points), visible_fraction(points, SUN, MOON))
    assert sun_visibility(scene, (0.0, 1e8, 0.0)).tolist() == [1.0]
    assert sun_visibility(Scene(EARTH, SUN), points).tolist() == [1.0, 1.0]
    with pytest.raises(ParameterError) as caught:
        sun_visibility(scene, [[np.nan, 0, 0]])
    assert caught.value.name == "points"
