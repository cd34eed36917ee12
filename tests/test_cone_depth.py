"""Umbra, antumbra and penumbra as depths: whole pictures against the twin's intervals, from every side."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import intervals
from shadowatmo.passes.cone_depth import cone_axis, reaching_cones
from shadowatmo.rays import Rays
from shadowatmo.shadow import umbra_cone
from tests.cameras import SUN, R

MOON = sa.Occluder(center=(3.7e8, 1.5e6, 1e6), radius=1.7374e6)
FAR_MOON = sa.Occluder(center=(4.1e8, -1e6, 0.5e6), radius=1.7374e6)  # its apex is before the air
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
                # float32: half a meter across the axis; from the sunward camera 32 m along the ray
                assert error.max() < (100.0 if name == "sunward of the moon" else 10.0), kind
                found_some += np.count_nonzero(last > first)
    assert found_some > 20


def test_which_cones_reach_the_air():
    near = sa.Occluder((3.55e8, 1.5e6, 1e6), 1.7374e6)
    assert set(reaching_cones(sa.EARTH, SUN, near)) == {"outer", "umbra"}
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
