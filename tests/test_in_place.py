"""Only what may show air is drawn, and blended into what is there: against whole frames written anew."""

import dataclasses
import math

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes import canvas as canvases
from shadowatmo.passes.adaptive import TILE, AdaptiveComposite
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.view import View
from shadowatmo.screen import area
from tests.cameras import CAMERAS, SUN, R, facing
from tests.gl_state import HostObjects, difference, snapshot

SIZE = (160, 88)
QUALITY = sa.Quality(depth="analytic", orders=1, tolerance=0.006)
EVERY = dataclasses.replace(QUALITY, tolerance=0.0)
FIELDS = "color", "depth", "lit_width", "shadow_width"
SECOND = sa.Sun(direction=(0, 1, 0.3), irradiance=(0.2, 0.1, 0.05))
# Of the frame's brightest: a pixel that lies on a sample of the grid gets 1e-6 of the sample beside it by rounding, and
# none of it where that tile is not drawn.
ROUNDING = 3e-6
TOP = sa.EARTH.top_radius


def beside(degrees, fov=60.0, distance=2e7):
    """Return a camera whose picture's left edge passes the air's limb at an angle [degrees]; positive: empty."""
    turn = math.atan(math.tan(math.radians(fov) / 2) * SIZE[0] / SIZE[1]) + math.asin(TOP / distance)
    turn += math.radians(degrees)
    forward = -math.cos(turn), math.sin(turn), 0.0
    return sa.Camera(position=(distance, 0, 0), forward=forward, up=(0, 0, 1), vertical_fov=math.radians(fov))


MORE = {
    "the air's edge on the picture's": beside(0.0),
    "a sliver of air": beside(-0.3),
    "just beside the air": beside(0.3),
    "the planet behind": sa.Camera(position=(2e7, 0, 0), forward=(1, 0.1, 0)),
    "half of it outside": sa.Camera(position=(2e7, 0, 0), forward=(-1, 0.55, 0.1)),
    "175 degrees wide": facing((1, 1, 0.2), 1e7, 175),
    "0.01 degrees at the limb": sa.Camera(
        position=(2e7, 0, 0), target=(0, 1.003 * R, 0), up=(0, 0, 1), vertical_fov=math.radians(0.01)
    ),
    "along the top": sa.Camera(position=(TOP + 1e3, 0, 0), forward=(0, 1, 0), up=(1, 0, 0), vertical_fov=2.5),
    "the Moon's distance, 60 degrees": facing((-0.9, 0.5, 0.1), 3.844e8, 60),
}
ALL = CAMERAS | MORE
SOME = {name: CAMERAS[name] for name in ("2 m, sunset", "400 km, sunset", "20 000 km, half phase")} | MORE


def whole(monkeypatch, renderer):
    """Make a renderer draw whole frames that read the background, as where no blending has two sources."""
    monkeypatch.setattr(View, "air_window", property(lambda view: (0, 0, *view.size)))
    renderer._passes["adaptive"].blends = False


def agree(found, truth):
    light = np.abs(found - truth)[..., :3].max() <= ROUNDING * max(truth[..., :3].max(), 1e-30)
    return light and np.abs(found - truth)[..., 3].max() < 3e-6  # alpha in [0, 1]


@pytest.fixture
def host(ctx, rng):
    """A host's color and the framebuffer that has it, a depth with a ball before the planet, and the pixels."""
    pixels = rng.random((*SIZE[::-1], 4), np.float32)
    pixels[..., 3] = np.round(pixels[..., 3])
    pixels[::5, ::7, :3] = (3e4, 1e-20, 0.0)
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    distance = np.where(np.hypot(x - 70, y - 40) < 12, np.float32(1e3), np.float32(np.inf))
    color = ctx.texture(SIZE, 4, pixels.tobytes(), dtype="f4")
    depth = ctx.texture(SIZE, 1, distance.astype(np.float32).tobytes(), dtype="f4")
    target = ctx.framebuffer([color], ctx.depth_texture(SIZE))
    yield color, depth, target, pixels
    for item in (target, color, depth):
        item.release()


def contents(texture):
    return np.frombuffer(texture.read(), np.float32).reshape(*SIZE[::-1], 4)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(
    "scene",
    [sa.Scene(suns=SUN), sa.Scene(suns=(SUN, SECOND), surface=sa.Surface(), sun_disc=True)],
    ids=["air alone", "two suns, their discs, lit ground"],
)
def test_the_same_as_whole_frames(ctx, monkeypatch, scene, name):
    with sa.Renderer(ctx, scene, SIZE, QUALITY) as renderer:
        renderer.render(CAMERAS["400 km, sunset"])  # which must leave no trace
        found = renderer.render(ALL[name]).read("color").copy()
        assert np.array_equal(renderer.render(ALL[name]).read("color"), found)
        whole(monkeypatch, renderer)
        truth = renderer.render(ALL[name]).read("color")
        assert agree(found, truth)
        if truth[..., :3].max() > 0.0:
            assert not agree(1.00001 * found, truth)


@pytest.mark.parametrize("name", MORE)
def test_every_pixel_of_a_window_alone(ctx, monkeypatch, host, name):
    """The same without tiles: widths and classes in the window, copies and discs around it."""
    color, depth, _, _ = host
    scene = sa.Scene(suns=(SUN, SECOND), surface=sa.Surface(), sun_disc=True)

    def fields(renderer):
        frames = lambda: renderer.compose(color, depth, MORE[name]), lambda: renderer.render(MORE[name])
        return [frame().read(field).copy() for frame in frames for field in FIELDS]

    with sa.Renderer(ctx, scene, SIZE, EVERY) as renderer:
        renderer.render(CAMERAS["400 km, sunset"])
        found = fields(renderer)
        monkeypatch.setattr(View, "air_window", property(lambda view: (0, 0, *view.size)))
        truth = fields(renderer)
    assert all(np.array_equal(a, b) for a, b in zip(found, truth, strict=True))


@pytest.mark.parametrize("name", ["20 000 km, half phase", "half of it outside", "the Moon's distance, 60 degrees"])
def test_all_orders_moons_rings_and_a_finite_disc(ctx, monkeypatch, name):
    sun = dataclasses.replace(SUN, direction=(0.2, 1.0, 0.35), disc_at_terminator=True)
    moon = sa.Occluder(center=tuple(3e8 * np.array(sun.direction) + (1e6, 0, 0)), radius=1.7e6)
    ring = sa.Ring((0, 0, 0), (0, 0.1, 1), 1.4 * R, 1.6 * R, optical_depth=1.0)
    scene = sa.Scene(suns=(sun, SECOND), occluders=(moon,), rings=(ring,), surface=sa.Surface(), sun_disc=True)
    with sa.Renderer(ctx, scene, SIZE, "fast") as renderer:
        found = renderer.render(ALL[name]).read("color").copy()
        whole(monkeypatch, renderer)
        truth = renderer.render(ALL[name]).read("color")
    assert agree(found, truth) and truth[..., :3].max() > 0.0


@pytest.mark.parametrize("name", SOME)
def test_a_hosts_picture_in_place(ctx, monkeypatch, host, name):
    """What is drawn into the host's texture is what a frame of its own holds, and empty pixels keep every bit."""
    color, depth, target, pixels = host
    scene = sa.Scene(suns=(SUN, SECOND), sun_disc=True)
    with sa.Renderer(ctx, scene, SIZE, QUALITY) as renderer:
        elsewhere = renderer.compose(color, depth, ALL[name]).read("color").copy()
        assert np.array_equal(contents(color), pixels)
        renderer.compose(color, depth, ALL[name], target=target)
        found = contents(color)[::-1]
        color.write(pixels.tobytes())
        view = View(scene, QUALITY, ALL[name], SIZE)
        whole(monkeypatch, renderer)
        truth = renderer.compose(color, depth, ALL[name]).read("color")
    assert agree(elsewhere, truth)
    assert np.allclose(found[..., :3], truth[..., :3], rtol=3e-6, atol=ROUNDING * truth[..., :3].max())
    before = pixels[::-1]
    assert np.array_equal(found[..., 3], before[..., 3])
    empty = np.ones(SIZE[::-1], bool)
    for window in {w for sun in scene.suns for w in view.windows(sun, TILE)} - {None}:
        left, bottom, right, top = window
        empty[SIZE[1] - top : SIZE[1] - bottom, left:right] = False
    clear = empty | (truth[..., 3] == 0.0) & (truth[..., :3] == before[..., :3]).all(-1)
    assert found[clear].tobytes() == before[clear].tobytes()
    assert empty.any() == (area(view.air_window) < SIZE[0] * SIZE[1] * 0.9)


def test_a_frame_composed_in_place_can_be_read(ctx, host):
    color, depth, target, pixels = host
    camera = CAMERAS["20 000 km, half phase"]
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, QUALITY) as renderer:
        elsewhere = renderer.compose(color, depth, camera)
        fields = [elsewhere.read(name).copy() for name in ("depth", "lit_width", "shadow_width")]
        frame = renderer.compose(color, depth, camera, target=target)
        assert np.array_equal(frame.read("color"), contents(color)[::-1]) and frame.image().size == SIZE
        for name, field in zip(("depth", "lit_width", "shadow_width"), fields, strict=True):
            assert np.array_equal(frame.read(name), field)
        color.write(pixels.tobytes())
        assert np.array_equal(renderer.compose(color.glo, depth, camera, target=target).read("color"), frame_of(color))


def frame_of(color):
    return contents(color)[::-1]


@pytest.mark.parametrize("quality", [QUALITY, EVERY])
@pytest.mark.parametrize("dtype", ["f1", "f2"])
def test_every_format_and_way_keeps_the_hosts_alpha(ctx, rng, quality, dtype):
    """A texture of 8 bits is not blended into, but written by a copy."""
    values = rng.random((*SIZE[::-1], 4))
    kind, top = (np.uint8, 255) if dtype == "f1" else (np.float16, 1)
    color = ctx.texture(SIZE, 4, (values * top).astype(kind).tobytes(), dtype=dtype)
    depth = ctx.texture(SIZE, 1, np.full(SIZE[::-1], np.inf, np.float32).tobytes(), dtype="f4")
    target = ctx.framebuffer([color])

    def read():
        return np.frombuffer(color.read(), kind).reshape(*SIZE[::-1], 4)[::-1] / top

    before = read()
    assert canvases.draws_into(ctx, target, color) == (dtype == "f2")
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, quality) as renderer:
        camera = CAMERAS["400 km, day"]
        wanted = renderer.compose(color, depth, camera).numpy().copy()
        renderer.compose(color, depth, camera, target=target)
    assert np.array_equal(read()[..., 3], before[..., 3])
    assert np.allclose(read()[..., :3], np.clip(wanted, 0, 1), atol=1 / 255, rtol=1e-3)
    for item in (target, color, depth):
        item.release()


def test_what_is_in_place(ctx, host):
    color, depth, target, _ = host
    other = ctx.texture(SIZE, 4, dtype="f4")
    second = ctx.framebuffer([other, color])
    assert canvases.draws_into(ctx, target, color) and canvases.shares(ctx, target, color)
    assert not canvases.draws_into(ctx, target, other) and not canvases.draws_into(ctx, second, color)
    target.viewport = 8, 8, 16, 16  # the host wants a part of it: copied there, as ever
    assert not canvases.draws_into(ctx, target, color)
    before = contents(color)
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, QUALITY) as renderer:
        renderer.compose(color, depth, CAMERAS["400 km, day"], target=target)
    changed = np.argwhere((contents(color) != before).any(-1))
    assert changed.min(0).tolist() == [8, 8] and changed.max(0).tolist() == [23, 23]
    target.viewport, target.color_mask = (0, 0, *SIZE), (True, False, True, True)
    before = contents(color)
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, QUALITY) as renderer:
        renderer.compose(color, depth, CAMERAS["400 km, day"], target=target)
    assert (contents(color) != before).any((0, 1)).tolist() == [True, False, True, False]
    second.release()
    other.release()


def test_a_disc_beside_the_air_appears(ctx, host, monkeypatch):
    """The sun stands in the empty part of the picture, and behind a ball of the host's."""
    color, depth, target, pixels = host
    camera = sa.Camera(position=(-2e7, 0, 0), forward=(1.0, 0.0, 0.0), up=(0, 0, 1), vertical_fov=1.2)
    toward = np.array([1.0, 0.75, 0.0])
    scene = sa.Scene(suns=sa.Sun(direction=toward / np.linalg.norm(toward)), sun_disc=True)
    window, disc = View(scene, QUALITY, camera, SIZE).windows(scene.suns[0], TILE)
    assert window is not None and disc is not None and area(disc) < 100
    with sa.Renderer(ctx, scene, SIZE, QUALITY) as renderer:
        renderer.compose(color, depth, camera, target=target)
        left, bottom, right, top = disc
        lit = contents(color)[..., :3].max(-1) > 0.9e3 * pixels[..., :3].max(-1)
        assert lit[bottom:top, left:right].any()
        drawn = renderer.render(camera).numpy()
        assert drawn[SIZE[1] - top : SIZE[1] - bottom, left:right].max() > 1e3
        hidden = ctx.texture(SIZE, 1, np.ones(SIZE[::-1], np.float32).tobytes(), dtype="f4")
        color.write(pixels.tobytes())
        renderer.compose(color, hidden, camera, target=target)
        assert contents(color).tobytes() == pixels.tobytes()
        hidden.release()
        monkeypatch.setattr(View, "windows", lambda view, *_: (view.air_window, None))
        assert renderer.render(camera).numpy().max() < 1.0


@pytest.mark.parametrize("size", [(4096, 1), (1, 4096), (7, 9), (33, 17)])
def test_slits(ctx, monkeypatch, size):
    scene = sa.Scene(suns=SUN, surface=sa.Surface(), sun_disc=True)
    share = 4.0 * TOP / 2e7 * min(1.0, size[1] / size[0])
    camera = sa.Camera(position=(1e7, 1.7e7, 0), target=(0, 0, 1e6), vertical_fov=2.0 * math.atan(0.5 * share))
    with sa.Renderer(ctx, scene, size, QUALITY) as renderer:
        found = renderer.render(camera).read("color").copy()
        whole(monkeypatch, renderer)
        truth = renderer.render(camera).read("color")
    # the sparse look-up of the brightest sample meets others in a window than in the frame
    assert np.abs(found - truth)[..., :3].max() < QUALITY.tolerance * truth[..., :3].max() and truth.max() > 0.0


def test_nothing_to_see_costs_no_pass(ctx, monkeypatch):
    drawn = []
    original = AdaptiveComposite.fullscreen

    def noted(self, fragment, *arguments, **named):
        drawn.append(fragment)
        return original(self, fragment, *arguments, **named)

    monkeypatch.setattr(AdaptiveComposite, "fullscreen", noted)
    quality = dataclasses.replace(QUALITY, orders="all")
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, quality) as renderer:
        renderer.render(CAMERAS["400 km, day"])
        assert {"adaptive_grid.frag", "adaptive_tiles.frag", "adaptive_reconstruct.frag"} <= set(drawn)
        drawn.clear()
        frame = renderer.render(MORE["the planet behind"])
        assert drawn == [] and "multiple_view" not in frame._textures and frame.read("color").max() == 0.0


def test_nothing_of_it_in_the_text_where_it_is_not_used():
    for fragment in ("adaptive_reconstruct.frag", "atmosphere.frag"):
        defines = {"TILE_PIXELS": 8} if fragment.startswith("adaptive") else {}
        assert "out_passed" not in compose_source(fragment, defines).text
        if not defines:
            defines = {"HAS_SOLVED_CUTS": True}
        assert "out_passed" in compose_source(fragment, {**defines, "HAS_IN_PLACE": True}).text


def test_the_plan_says_it(ctx):
    plans = {}
    for surface in (None, sa.Surface()):
        for tolerance in (0.0, 0.006):
            scene, quality = sa.Scene(suns=SUN, surface=surface), dataclasses.replace(QUALITY, tolerance=tolerance)
            with sa.Renderer(ctx, scene, SIZE, quality) as renderer:
                plans[surface is not None, tolerance] = str(renderer.plan)
    assert "in place" in plans[True, 0.006] and "in_place: left out" not in plans[True, 0.006]
    assert "in_place: left out, nothing stands behind the air" in plans[False, 0.006]
    assert "window of the frame" in plans[False, 0.006]
    for lit in (False, True):
        assert "in_place" not in plans[lit, 0.0] and "in place" not in plans[lit, 0.0]


def test_without_two_sources_of_blending(ctx, monkeypatch, host):
    color, depth, target, pixels = host
    camera = CAMERAS["20 000 km, half phase"]
    scene = sa.Scene(suns=SUN, surface=sa.Surface())
    frames = []
    for missing in (False, True):
        if missing:
            monkeypatch.setattr("shadowatmo.passes.pipeline.has_dual_source", lambda _: False)
        with sa.Renderer(ctx, scene, SIZE, QUALITY) as renderer:
            assert ("cannot blend" in str(renderer.plan)) == missing
            drawn = renderer.render(camera).read("color").copy()
            renderer.compose(color, depth, camera, target=target)
            frames.append((drawn, contents(color)))
            color.write(pixels.tobytes())
    assert agree(frames[0][0], frames[1][0]) and agree(frames[0][1], frames[1][1])


def test_the_hosts_state_comes_back(ctx, host):
    color, depth, target, pixels = host
    camera = CAMERAS["20 000 km, half phase"]
    scene = sa.Scene(suns=SUN, surface=sa.Surface(), sun_disc=True)
    with sa.Renderer(ctx, scene, SIZE, QUALITY) as renderer, preserve_state(ctx):
        renderer.compose(color, depth, camera, target=target)
        plain, drawn = contents(color).copy(), renderer.render(camera).numpy()
        color.write(pixels.tobytes())
        objects = HostObjects(ctx)
        objects.make_hostile()
        before = snapshot(ctx)
        renderer.compose(color, depth, camera, target=target)
        assert difference(before, snapshot(ctx)) == set()
        again = renderer.render(camera).numpy()
        assert difference(before, snapshot(ctx)) == set()
        assert np.array_equal(again, drawn)
    assert np.array_equal(contents(color), plain)
    objects.release()
