"""Umbra, antumbra and penumbra as depths: whole pictures against the twin's intervals, from every side."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import intervals
from shadowatmo.passes.cone_depth import cone_axis, reaching_cones
from shadowatmo.rays import Rays
from shadowatmo.shadow import cylinder, umbra_cone
from tests.cameras import SUN, R

MOON = sa.Occluder(center=(3.7e8, 1.5e6, 1e6), radius=1.7374e6)
FAR_MOON = sa.Occluder(center=(4.1e8, -1e6, 0.5e6), radius=1.7374e6)  # its apex is before the air
NEAR_MOON = sa.Occluder(center=(3.55e8, 1.5e6, 1e6), radius=1.7374e6)
AXIS, DISTANCE = cone_axis(SUN, FAR_MOON)
APEX = np.array(FAR_MOON.center) + umbra_cone(FAR_MOON.radius, SUN.radius, DISTANCE).far * AXIS
SPOT = np.array([np.sqrt(R * R - 3.25e12), 1.5e6, 1e6])
SIZE = (97, 55)


def looking(position, target, fov=1.0):
    return sa.Camera(position=tuple(position), target=tuple(target), vertical_fov=fov)


CAMERAS = {
    "400 km, beside the spot": looking(SPOT * (1 + 4e5 / R) + (0, 9e5, 3e5), SPOT),
    "10 km, beside the spot": looking(SPOT * (1 + 1e4 / R) + (0, 1.5e5, 0), SPOT * 1.001),
    "inside the umbra": looking(SPOT * (1 + 2e4 / R), SPOT * (1 + 2e4 / R) + (1e5, 4e4, 3e4), 1.8),
    "at the apex": looking(APEX, (0, 1e6, 0), 1.5),
    "sunward of the moon": looking((4.2e8, 2e6, 1e6), SPOT, 0.004),
    "on the night side": looking((-9e6, 1e6, 0), (0, 0, 0), 1.4),
}


def twin(camera, moon, kind):
    """Lengths (N,) [m] of the pixel rays' parts in the air inside one cone, and its two ends as distances."""
    directions = camera.pixel_rays(SIZE).reshape(-1, 3)
    rays = Rays.validated(np.tile(camera.position, (len(directions), 1)), directions)
    segments = intervals.trace(sa.EARTH, rays)
    first, last = getattr(intervals.cones(segments, moon.center, moon.radius, SUN), kind)
    return segments, first, last


@pytest.mark.parametrize("name", CAMERAS)
def test_cones_against_intervals(ctx, name):
    camera, found_some = CAMERAS[name], 0
    with sa.Renderer(ctx, sa.Scene(suns=SUN, occluders=(MOON, FAR_MOON)), SIZE, sa.Quality(orders=1)) as renderer:
        for depths in renderer.cone_depths(camera):
            for kind in ("outer", "umbra", "antumbra"):
                texture = getattr(depths, kind)
                segments, first, last = twin(camera, depths.occluder, kind)
                hit = segments.length > 0
                if texture is None:
                    assert np.max(last - first) == 0.0, kind
                    continue
                ends = renderer.read_texture(texture).reshape(-1, 2).astype(np.float64)
                assert np.isfinite(ends).all()
                inside = np.clip(ends - np.nan_to_num(segments.t_in)[:, None], 0.0, segments.length[:, None])
                error = np.abs((inside[:, 1] - inside[:, 0]) - (last - first))[hit]
                # a meter, where a ray grazes a cone, and the last digits of the two distances from the camera
                step = np.spacing(np.float32(np.nanmax(segments.t_in)))
                assert error.max() < 1.5 + 4.0 * step, kind
                found_some += np.count_nonzero(last > first)
    assert found_some > 20


@pytest.mark.parametrize("distance", [2e7, 1e9, 1e11])
def test_cones_keep_their_place_from_afar(ctx, distance):
    """A picture of 60 km of the umbra's edge: pixel by pixel the umbra is where the intervals say."""
    toward = np.array([0.7, 0.65, 0.1])
    edge = SPOT * (1 + 3e4 / R) + (0.0, 1.12e5, 0.0)
    camera = looking(edge + distance * toward / np.linalg.norm(toward), edge, 2.0 * np.arctan(3e4 / distance))
    segments, first, last = twin(camera, NEAR_MOON, "umbra")
    with sa.Renderer(ctx, sa.Scene(suns=SUN, occluders=NEAR_MOON), SIZE, sa.Quality(orders=1)) as renderer:
        (depths,) = renderer.cone_depths(camera)
        ends = renderer.read_texture(depths.umbra).reshape(-1, 2).astype(np.float64)
    lengths = np.diff(np.clip(ends - segments.t_in[:, None], 0.0, segments.length[:, None]))[:, 0]
    wanted = last - first
    assert np.min(wanted) == 0.0 and 0.2 < np.mean(wanted > 3e4) < 0.9
    step = np.spacing(np.float32(distance))
    assert np.max(np.abs(lengths - wanted)) < 10.0 + 3.0 * step
    # digits that the distances have not are noise, and no displacement of the edge
    assert abs(np.mean(lengths - wanted)) < 1.0 + 0.2 * step


def test_a_moved_cone_is_the_same():
    cone = umbra_cone(MOON.radius, SUN.radius, DISTANCE)
    for z in (-1e8, 0.0, 3.7e8):
        moved = cone.moved(z)
        assert np.isclose(moved.width(1e7), cone.width(z + 1e7), rtol=1e-12)
        assert np.allclose((moved.near + z, moved.far + z), (cone.near, cone.far), rtol=1e-9)
        assert (moved.excess, cylinder(R).moved(z).far) == (0.0, cylinder(R).far)


def test_which_cones_reach_the_air():
    assert set(reaching_cones(sa.EARTH, SUN, NEAR_MOON)) == {"outer", "umbra"}
    assert set(reaching_cones(sa.EARTH, SUN, MOON)) == {"outer", "umbra", "antumbra"}  # the apex lies inside the Earth
    assert set(reaching_cones(sa.EARTH, SUN, FAR_MOON)) == {"outer", "antumbra"}
    aside = sa.Occluder((3.7e8, 7.5e6, 0), 1.7374e6)
    assert set(reaching_cones(sa.EARTH, SUN, aside)) == {"outer"}


def test_plan_names_the_cones(ctx):
    scene = sa.Scene(suns=SUN, occluders=(sa.Occluder((0, 3.7e8, 0), 1e6), MOON))
    with sa.Renderer(ctx, scene, (8, 8), sa.Quality(orders=1)) as renderer:
        assert "penumbra, umbra, antumbra of occluder 1 in the light of sun 0" in str(renderer.plan)
        for _ in range(2):
            assert len(renderer.cone_depths(CAMERAS["at the apex"])) == 1
        renderer.scene = sa.Scene(suns=SUN)
        assert "cone_depth" not in str(renderer.plan) and renderer.cone_depths(CAMERAS["at the apex"]) == ()
