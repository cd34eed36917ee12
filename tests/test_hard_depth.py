"""Depth conventions of a host from near planes of 1 cm to 1000 km, in units of 1 m, 1 km and a planet's radius."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.depth import DepthConvention

R = sa.EARTH.bottom_radius
SIZE = (48, 6)
SCENE = sa.Scene(suns=sa.Sun((1.0, 0.4, 0.1)))
QUALITY = sa.Quality(nodes=12, orders=1, terms=6, depth="analytic")
NEARS = (0.01, 1.0, 1e3, 1e6)  # m
UNITS = {"1 m": 1.0, "1 km": 1e3, "a planet's radius": R}
FAR = 1e10  # m
# name: kind, whether there is a far plane, bits of the buffer (24 fixed or 32 float)
CONVENTIONS = {
    "standard, 24 bits": ("standard", True, 24),
    "standard, float": ("standard", True, 32),
    "standard, float, infinite": ("standard", False, 32),
    "reversed": ("reversed", True, 32),
    "reversed, infinite": ("reversed", False, 32),
    "logarithmic": ("logarithmic", True, 32),
    "logarithmic, 24 bits": ("logarithmic", True, 24),
    "linear": ("linear", False, 32),
    "distance": ("distance", False, 32),
}
# How far float32 is from float64 in decoding one and the same stored value, relative to the distance: a handful of
# roundings, but 40 bits of exponent to a logarithmic value, which float32 knows to 3e-6 of the power.
DECODING = {"logarithmic": 5e-6}
ROUNDINGS = 6e-7


def convention_of(name, near, unit):
    kind, has_far, _ = CONVENTIONS[name]
    return DepthConvention(
        kind, near=near / unit, far=FAR / unit if has_far else np.inf, coefficient=unit / near, meters_per_unit=unit
    )


def upward(depth, altitude=2.0):
    """A camera that sees no ground, so that nothing but the host's surface ends a ray."""
    return sa.Camera(position=(R + altitude, 0.0, 0.0), forward=(1.0, 0.1, 0.0), vertical_fov=0.5, depth=depth)


def depth_texture(ctx, name, values):
    """Upload values (h, w), row 0 at the top, into the kind of buffer that a host would have."""
    data = np.ascontiguousarray(values[::-1], np.float32)
    if CONVENTIONS[name][2] == 24:
        return ctx.depth_texture(SIZE, data.tobytes())
    return ctx.texture(SIZE, 1, data.tobytes(), dtype="f4")


@pytest.fixture(scope="module")
def host(ctx):
    """A renderer and a black color texture."""
    color = ctx.texture(SIZE, 4, np.zeros((*SIZE[::-1], 4), np.float32).tobytes(), dtype="f4")
    with sa.Renderer(ctx, SCENE, SIZE, QUALITY) as renderer:
        yield renderer, color
    color.release()


def composed(ctx, host, name, camera, values):
    """Return the depth that was understood (h, w) [m], the light (h, w, 3), and the values that the buffer kept."""
    renderer, color = host
    texture = depth_texture(ctx, name, values)
    try:
        kept = np.frombuffer(texture.read(alignment=1), np.float32).reshape(SIZE[::-1])[::-1]
        frame = renderer.compose(color, texture, camera)
        return frame.read("depth")[..., 0].astype(np.float64), frame.numpy().astype(np.float64), kept.astype(np.float64)
    finally:
        texture.release()


def surfaces(camera, near):
    """Return distances (h, w) [m] that grow from left to right from the near plane to 3e9 m, and the rays' stretch."""
    stretch = 1.0 / (camera.pixel_rays(SIZE) @ np.array(camera.forward))
    eye_depth = np.geomspace(1.2 * near, 3e9, SIZE[0])
    return eye_depth * stretch, stretch


@pytest.mark.parametrize("name", CONVENTIONS)
@pytest.mark.parametrize("unit", UNITS)
def test_distances(ctx, host, name, unit):
    for near in NEARS:
        convention = convention_of(name, near, UNITS[unit])
        camera = upward(convention)
        distances, stretch = surfaces(camera, near)
        found, light, kept = composed(ctx, host, name, camera, convention.encode(distances, stretch))
        want = convention.distance(kept, stretch)
        assert np.isfinite(light).all() and (light >= 0.0).all()
        # a driver may turn the last of 2^24 steps before the far plane into it: 1 - 6e-8 rounds to 1 on the way
        sure = kept <= 1.0 - 1.5 * 2.0**-24 if CONVENTIONS[name][2] == 24 else np.ones_like(kept, bool)
        sure |= kept == 1.0
        assert np.array_equal(np.isinf(found[sure]), np.isinf(want[sure]))
        there = np.isfinite(want) & np.isfinite(found)
        # one step of the buffer, as a share of the distance
        step = 2.0**-24
        resolution = {
            "standard": step * distances / near,
            "logarithmic": np.full_like(distances, 40.0 * step),
        }.get(convention.kind, np.full_like(distances, 2.0 * step))
        # float32 against float64 for one and the same value, which a driver has turned from fixed point to float itself
        decoding = DECODING.get(convention.kind, ROUNDINGS) + (1.5 * resolution if CONVENTIONS[name][2] == 24 else 0.0)
        there &= resolution < 0.1
        error = np.where(there, np.abs(found / np.where(there, want, 1.0) - 1.0), 0.0)
        assert np.all(error <= decoding), (near, error.max())
        # farther surfaces are not nearer, but for the last digits of an exponent
        row = found[2] / stretch[2]
        row = row[np.isfinite(row)]
        assert np.all(np.diff(row) > -5e-6 * row[:-1])
        # and the buffer, decoded, says where the surface was as well as its bits can tell
        assert np.all(np.abs(found / distances - 1.0)[there] < (2.0 * resolution + decoding)[there])
        assert there[:, : SIZE[0] // 4].all()


@pytest.mark.parametrize("name", CONVENTIONS)
def test_light_before_a_surface(ctx, host, name):
    """The light of the air in front of a host's surface is the twin's for the distance that the buffer tells."""
    convention = convention_of(name, 1.0, 1e3)
    camera = upward(convention)
    distances, stretch = surfaces(camera, 1.0)
    _, light, kept = composed(ctx, host, name, camera, convention.encode(distances, stretch))
    rays = camera.pixel_rays(SIZE).reshape(-1, 3)
    limits = convention.distance(kept, stretch).ravel()
    truth = reference.probe(SCENE, np.tile(camera.position, (len(rays), 1)), rays, t_max=limits).single
    # 12 nodes to a path without a limb; the decoded distance as in DECODING, which short paths are proportional to
    assert np.max(np.abs(light.reshape(-1, 3) / truth - 1.0)) < 1e-3


@pytest.mark.parametrize("name", CONVENTIONS)
def test_nothing_drawn_is_nothing(ctx, host, name):
    """A cleared buffer ends no ray."""
    convention = convention_of(name, 1.0, 1.0)
    values = np.full(SIZE[::-1], convention.encode(np.inf))
    found, light, _ = composed(ctx, host, name, upward(convention), values)
    assert np.isinf(found).all()
    with sa.Renderer(ctx, SCENE, SIZE, QUALITY) as renderer:
        alone = renderer.render(upward(convention)).numpy()
    assert np.array_equal(light.astype(np.float32), alone)


def test_a_surface_moved_a_little_changes_little(ctx, host):
    """1e-6 of the distance more in front of a surface: the light of that much air more, and float32's last digits."""
    convention = DepthConvention("distance")
    camera = upward(convention)
    distances, _ = surfaces(camera, 1.0)
    before = composed(ctx, host, "distance", camera, distances)[1]
    after = composed(ctx, host, "distance", camera, distances * (1.0 + 1e-6))[1]
    assert np.max(np.abs(after / before - 1.0)) < 1e-5


def test_the_wrong_convention_is_noticed(ctx, host):
    """The rejected case: reversed depth read as standard."""
    near = 1.0
    right, wrong = convention_of("reversed", near, 1.0), convention_of("standard, float", near, 1.0)
    camera = upward(wrong)
    distances, stretch = surfaces(camera, near)
    found, *_ = composed(ctx, host, "reversed", camera, right.encode(distances, stretch))
    assert np.nanmax(np.abs(found / distances - 1.0)) > 0.5
