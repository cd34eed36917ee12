"""Frames that are interpolated between the corners of tiles, against frames whose every pixel is evaluated."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.adaptive import CURVED, MIXED, AdaptiveComposite
from shadowatmo.passes.gl.state import preserve_state
from tests.cameras import CAMERAS, SUN, above, facing, level
from tests.gl_state import HostObjects, difference, snapshot

SIZE = (320, 184)
LARGE = (1280, 720)
# Not within the bars at SIZE, where a tile is four times as wide: 0.55 % at a billionth of daylight.
NIGHT = "2 m, deep night"
TOLERANCE = 0.006
FULL = sa.Quality(depth="analytic", orders=1)
P99, WORST = 0.5, 3.0  # percent of the pixel's brightest channel
SCENE = sa.Scene(suns=SUN)


def adaptive(quality, tolerance=TOLERANCE):
    return dataclasses.replace(quality, tolerance=tolerance)


def errors(pixels, truth, dark=1e-4):
    """Return errors [%] of the pixels' brightest channels, where they are above `dark` of the frame's maximum."""
    level = truth.max(-1)
    bright = (level > dark * level.max()) & (level > 0.0)
    found = 100.0 * np.abs(pixels - truth).max(-1)[bright] / level[bright]
    return found if found.size else np.zeros(1)


def both(ctx, scene, camera, size=SIZE, quality=FULL, tolerance=TOLERANCE, draw=None):
    """Return the frames without and with interpolation, and the kinds of tiles."""
    draw = draw or (lambda renderer: renderer.render(camera).numpy())
    with sa.Renderer(ctx, scene, size, quality) as renderer:
        full = draw(renderer)
    with sa.Renderer(ctx, scene, size, adaptive(quality, tolerance)) as renderer:
        smooth = draw(renderer)
        tiles = renderer._passes["adaptive"].tiles.read_color()[..., 0]
    return full, smooth, tiles


def holds(found):
    return np.percentile(found, 99) < P99 and found.max() < WORST


@pytest.mark.parametrize("name", CAMERAS)
def test_on_is_off(ctx, name):
    full, smooth, _ = both(ctx, SCENE, CAMERAS[name])
    assert holds(errors(smooth, full))


@pytest.mark.parametrize("name, size", [(n, s) for n in CAMERAS for s in (SIZE, LARGE) if (n, s) != (NIGHT, SIZE)])
def test_on_is_off_in_all_light(ctx, name, size):
    quality = adaptive(sa.quality.NAMED["balanced"], 0.0)
    full, smooth, _ = both(ctx, SCENE, CAMERAS[name], size, quality)
    assert holds(errors(smooth, full))


@pytest.mark.parametrize("quality", [sa.Quality(orders=1), sa.Quality(depth="analytic", method="widths")])
def test_on_is_off_by_other_means(ctx, quality):
    for name in ("2 m, twilight, away from the sun", "400 km, day"):
        full, smooth, _ = both(ctx, SCENE, CAMERAS[name], quality=quality, tolerance=0.5 * TOLERANCE)
        assert holds(errors(smooth, full)), name


def test_from_afar_all_orders_are_what_they_are_without(ctx):
    """High cameras keep the texels of the view table: only slices that hold no path of theirs are left out."""
    full, smooth, _ = both(ctx, SCENE, CAMERAS["20 000 km, half phase"], quality=sa.Quality(depth="textures"))
    assert holds(errors(smooth, full))


def test_full_size_costs_a_tenth(ctx):
    full, smooth, tiles = both(ctx, SCENE, CAMERAS["2 m, sunset"], (1280, 720))
    assert holds(errors(smooth, full))
    assert 0.02 < np.mean(tiles > 0) < 0.15
    full, smooth, tiles = both(ctx, SCENE, CAMERAS["2 m, sunset"], (1280, 720), tolerance=0.1)
    assert not holds(errors(smooth, full))
    assert np.mean(tiles > 0) < 0.05


@pytest.mark.parametrize("name", ["2 m, sunset", "1 km, on the shadow's edge"])
def test_what_falls_off_like_an_exponential_is_interpolated(ctx, monkeypatch, name):
    """Half of the tiles that bend too much for straight lines do for parabolas in the logarithm."""
    full, smooth, tiles = both(ctx, SCENE, CAMERAS[name], (1280, 720))
    curved = np.kron(tiles[::-1] == CURVED, np.ones((8, 8), bool))
    assert holds(errors(smooth[curved], full[curved]))
    assert np.mean(tiles == CURVED) > 0.8 * np.mean((tiles > 0) & (tiles < CURVED))
    monkeypatch.setattr(AdaptiveComposite, "_draw_curved", lambda *_: None)
    _, straight, _ = both(ctx, SCENE, CAMERAS[name], (1280, 720))
    assert not holds(errors(straight[curved], full[curved]))


def test_the_limb_from_afar(ctx, rng, monkeypatch):
    """Paths of 1700 km through the lowest air, before the sun or with the planet's shadow on them."""
    exact = sa.Quality(nodes=32, gap_nodes=16, terms=6, orders=1)

    def worst(camera, size=(1280, 720)):
        _, smooth, tiles = both(ctx, SCENE, camera, size)
        rows, columns = np.nonzero(np.kron(tiles[::-1] == MIXED, np.ones((8, 8), bool)))
        some = rng.choice(len(rows), 3000, replace=False)
        rays = camera.pixel_rays(size)[rows[some], columns[some]]
        truth = sa.probe(ctx, SCENE, np.broadcast_to(camera.position, rays.shape), rays, quality=exact).single
        return np.percentile(errors(smooth[rows[some], columns[some]], truth), 99)

    cameras = CAMERAS["1e9 m, behind the planet"], level(104, 1e5, 0, -12)
    bar = 1.4  # measured: 0.4 and 1.1, and from 2.5 to 6 without what the limb has of its own
    assert max(worst(camera) for camera in cameras) < bar
    monkeypatch.setattr("shadowatmo.passes.atmosphere.has_long_paths", lambda view: False)
    assert min(worst(camera) for camera in cameras) > 1.5 * bar


def test_the_night_is_smooth_when_it_is_stretched(ctx, monkeypatch):
    """Light below 1e-4 of the frame need not be right to the tolerance, but without corners at every eighth pixel."""
    quality, camera = sa.Quality(depth="analytic"), CAMERAS["20 000 km, half phase"]
    _, truth, _ = both(ctx, SCENE, camera, (1280, 720), quality, tolerance=1e-9)
    level = truth.max(-1)
    night = (level > 1e-6 * level.max()) & (level < 1e-4 * level.max())

    def error():
        _, smooth, _ = both(ctx, SCENE, camera, (1280, 720), quality)
        return np.percentile(np.abs(smooth - truth).max(-1)[night] / level[night], 90)

    assert error() < 0.02
    monkeypatch.setattr(AdaptiveComposite, "_draw_curved", lambda *_: None)
    assert error() > 0.06


@pytest.mark.parametrize("surface", [sa.Surface(), sa.Surface.earth()])
def test_a_ground_behind_interpolated_air(ctx, surface):
    """The transmittance is bent as the light is."""
    scene, camera = sa.Scene(suns=SUN, surface=surface), CAMERAS["20 000 km, half phase"]
    full, smooth, tiles = both(ctx, scene, camera, (640, 368))
    curved = np.kron(tiles[::-1] == CURVED, np.ones((8, 8), bool))
    assert curved.sum() > 64 and holds(errors(smooth[curved], full[curved]))


def test_all_orders_are_as_right_as_without(ctx, rng):
    """The view table of whole paths against quadrature along rays."""
    quality = sa.Quality(depth="analytic")
    exact = sa.Quality(nodes=20, gap_nodes=10, terms=6)
    for name in ("2 m, sunset", "2 m, deep night", "10 km, low sun", "400 km, day"):
        camera, size = CAMERAS[name], LARGE if name == NIGHT else SIZE
        row, column = rng.integers(0, size[1], 500), rng.integers(0, size[0], 500)
        rays = camera.pixel_rays(size)[row, column]
        probe = sa.probe(ctx, SCENE, np.broadcast_to(camera.position, rays.shape), rays, quality=exact)
        truth = probe.single + probe.multiple
        full, smooth, _ = both(ctx, SCENE, camera, size, quality)
        without, found = (np.percentile(errors(f[row, column], truth), 99) for f in (full, smooth))
        assert found < max(0.5, without + 0.2), name  # 8 nodes; what interpolation adds


def host_depth(distance):
    """Return a host's distances [m] (h, w) from the bottom up: hills, a ball, a pole and a wire one pixel wide."""
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    hill = 100 + 15 * np.sin(x / 40.0) + 5 * np.sin(x / 6.0)
    depth = np.where(y > hill, distance * (0.2 + 0.8 * np.exp(-(y - hill) / 30.0)), np.inf)
    depth = np.where(np.hypot(x - 80, y - 50) < 17, 0.3 * distance, depth)
    depth[:, 251] = 0.05 * distance
    depth[27] = 0.4 * distance
    return np.ascontiguousarray(depth[::-1], np.float32)


@pytest.mark.parametrize("name, distance", [("2 m, sunset", 3e4), ("10 km, low sun", 5e4), ("400 km, day", 1.5e6)])
def test_silhouettes_have_no_halo(ctx, monkeypatch, name, distance):
    depth = host_depth(distance)
    color = np.where(np.isfinite(depth)[..., None], np.float32([0.02, 0.03, 0.01, 1.0]), np.float32(0.0))
    textures = ctx.texture(SIZE, 4, color.tobytes(), dtype="f4"), ctx.texture(SIZE, 1, depth.tobytes(), dtype="f4")

    def composed(renderer):
        return renderer.compose(*textures, CAMERAS[name]).numpy()

    full, smooth, tiles = both(ctx, SCENE, None, draw=composed)
    assert holds(errors(smooth, full)) and np.mean(tiles > 0) < 0.9
    monkeypatch.setattr(AdaptiveComposite, "_draw_points", lambda *_: None)
    _, blurred, _ = both(ctx, SCENE, None, draw=composed)
    assert errors(blurred, full).max() > 2 * WORST
    for texture in textures:
        texture.release()


def test_a_moons_shadow_smaller_than_a_tile_is_seen(ctx, monkeypatch):
    """From far away the shadow of a moon of 60 km is 2 pixels wide; in some places no corner of a tile meets it."""
    camera = facing((1.0, 0.8, 0.3), 2e7, 45)
    bare, _, _ = both(ctx, SCENE, camera)
    frames = []
    for zenith in (50.0, 51.3, 52.6):
        moon = sa.Occluder(center=tuple(above(zenith, 0.0) + (1e7, 0.0, 0.0)), radius=6e4)
        scene = dataclasses.replace(SCENE, occluders=(moon,))
        full, smooth, _ = both(ctx, scene, camera)
        shaded = bare.max(-1) - full.max(-1) > 0.2 * bare.max(-1)
        assert 0 < shaded.sum() < 20
        assert holds(errors(smooth, full)) and np.allclose(smooth[shaded], full[shaded], rtol=1e-3)
        frames.append((scene, full))
    monkeypatch.setattr("shadowatmo.passes.adaptive.shading_occluders", lambda *_: ())
    assert any(errors(both(ctx, scene, camera)[1], full).max() > 2 * WORST for scene, full in frames)


def test_a_rings_shadow_thinner_than_a_tile_is_seen(ctx, monkeypatch):
    sun = dataclasses.replace(SUN, direction=(1.0, 0.0, 0.35))
    inner = 1.6 * sa.EARTH.bottom_radius
    ring = sa.Ring((0, 0, 0), (0, 0.1, 1), inner, inner + 2e4, optical_depth=5.0)
    scene, camera = sa.Scene(suns=sun, rings=(ring,)), facing((1.0, 0.5, -0.3), 2e7, 45)
    full, smooth, tiles = both(ctx, scene, camera, (640, 368))
    assert holds(errors(smooth, full)) and np.mean(tiles > 0) < 0.3
    monkeypatch.setattr("shadowatmo.passes.adaptive.dimming_rings", lambda *_: ())
    _, blind, _ = both(ctx, scene, camera, (640, 368))
    assert errors(blind, full).max() > 2 * WORST


def test_a_pan_does_not_crawl(ctx):
    """What interpolation does to a pixel may not change from frame to frame by more than the bar of one frame."""
    start = level(88, 2.0, 10, 5)
    right, up, forward = start.basis()

    def worst_change(tolerance):
        changes, before = [], None
        on_quality = adaptive(FULL, tolerance)
        with sa.Renderer(ctx, SCENE, SIZE, FULL) as full, sa.Renderer(ctx, SCENE, SIZE, on_quality) as on:
            for step in range(60):
                turn = 1.3 * step * np.radians(60) / SIZE[1]
                camera = dataclasses.replace(
                    start, target=None, forward=tuple(np.cos(turn) * forward + np.sin(turn) * (right + 0.3 * up))
                )
                truth, found = full.render(camera).numpy(), on.render(camera).numpy()
                error = (found - truth).max(-1) / np.maximum(truth.max(-1), 1e-4 * truth.max())
                if before is not None:
                    changes.append(np.percentile(np.abs(error - before), 99))
                before = error
        return 100.0 * max(changes)

    assert worst_change(TOLERANCE) < P99
    assert worst_change(0.1) > P99


@pytest.mark.parametrize("size", [(1, 1), (1, 257), (640, 1), (7, 9), (33, 17), (203, 119), (4096, 1)])
def test_every_size(ctx, size):
    full, smooth, _ = both(ctx, SCENE, CAMERAS["400 km, day"], size)
    assert smooth.shape == (size[1], size[0], 3)
    assert holds(errors(smooth, full))


def test_suns_add_up(ctx):
    second = sa.Sun(direction=(0, 1, 0.3), irradiance=(0.2, 0.1, 0.05))
    scene = sa.Scene(suns=(SUN, second), sun_disc=True)
    full, smooth, _ = both(ctx, scene, CAMERAS["20 000 km, half phase"])
    assert holds(errors(smooth, full))
    alone, _, _ = both(ctx, SCENE, CAMERAS["20 000 km, half phase"])
    assert not holds(errors(smooth, alone))


def test_the_suns_disc_is_drawn_per_pixel(ctx):
    camera = sa.Camera(position=above(60, 4e5), forward=(1, 0, 0), up=(0, 0, 1), vertical_fov=0.2)
    full, smooth, _ = both(ctx, sa.Scene(suns=SUN, sun_disc=True), camera)
    assert full.max() > 1e3 and np.allclose(smooth, full, rtol=1e-5)


def test_a_lobe_narrower_than_a_tile_is_not_missed(ctx):
    narrow = dataclasses.replace(sa.EARTH, mie_g=0.995)
    full, smooth, tiles = both(ctx, sa.Scene(suns=SUN, atmosphere=narrow), level(75, 2.0, 1.3, 15.3))
    assert holds(errors(smooth, full))
    assert tiles.max() > 0


def test_lit_surface_and_relief(ctx):
    scene = sa.Scene(suns=SUN, surface=sa.Surface.earth(), sun_disc=True)
    for name in ("10 km, low sun", "20 000 km, half phase"):
        full, smooth, _ = both(ctx, scene, CAMERAS[name])
        assert holds(errors(smooth, full)), name


def test_triangles_where_points_are_too_small(ctx):
    _, points, tiles = both(ctx, SCENE, CAMERAS["2 m, sunset"], (203, 119))
    with sa.Renderer(ctx, SCENE, (203, 119), adaptive(FULL)) as renderer:
        assert renderer._passes["adaptive"].points
        renderer._passes["adaptive"].points = False
        triangles = renderer.render(CAMERAS["2 m, sunset"]).numpy()
    assert np.allclose(points, triangles, rtol=1e-5) and 0 < (tiles > 0).sum() < tiles.size


def test_opacity_and_fields_as_without(ctx):
    for name in ("2 m, twilight, away from the sun", "400 km, day"):
        frames = []
        for quality in (FULL, adaptive(FULL)):
            with sa.Renderer(ctx, SCENE, SIZE, quality) as renderer:
                frame = renderer.render(CAMERAS[name])
                frames.append([frame.read(f) for f in ("color", "depth", "lit_width", "shadow_width")])
        assert np.abs(frames[0][0][..., 3] - frames[1][0][..., 3]).max() < 2 * TOLERANCE
        for off, on in zip(frames[0][1:], frames[1][1:], strict=True):
            assert np.array_equal(off, on)


def test_same_call_same_bits_and_the_hosts_state_back(ctx):
    camera = CAMERAS["400 km, sunset"]
    with sa.Renderer(ctx, SCENE, SIZE, adaptive(FULL)) as renderer, preserve_state(ctx):
        plain = renderer.render(camera).numpy()
        renderer.render(CAMERAS["2 m, noon"])
        host = HostObjects(ctx)
        host.make_hostile()
        before = snapshot(ctx)
        assert np.array_equal(renderer.render(camera).numpy(), plain)
        assert difference(before, snapshot(ctx)) == set()
    host.release()


def test_the_plan_says_it(ctx):
    with sa.Renderer(ctx, SCENE, SIZE, adaptive(FULL)) as renderer:
        assert [step.name for step in renderer.plan.steps] == ["adaptive"]
        assert "0.006" in str(renderer.plan) and "widths: left out" in str(renderer.plan)
        assert not renderer.plan.check_inputs(())
    with sa.Renderer(ctx, SCENE, SIZE, FULL) as renderer:
        assert "adaptive" not in renderer.plan


@pytest.mark.parametrize("tolerance", [-1e-3, 0.11, np.nan, "0.01", True])
def test_a_bad_tolerance_is_refused(tolerance):
    with pytest.raises(sa.ParameterError, match="tolerance"):
        sa.Quality(tolerance=tolerance)
