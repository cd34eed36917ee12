"""Whole frames: pixels against the twin, every size, hostile state, bad input, composing with a host's picture."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.depth import DepthConvention
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.quality import as_quality
from tests.cameras import CAMERAS, SUN, level
from tests.gl_state import HostObjects, difference, snapshot

SIZE = (61, 35)
CAMERA = CAMERAS["400 km, day"]
SINGLE = dataclasses.replace(as_quality("accurate"), orders=1)
EARTH = sa.Scene(suns=SUN, surface=sa.Surface.earth(), sun_disc=True)


@pytest.mark.parametrize("name", CAMERAS)
def test_pixels_hold_what_the_twin_says(ctx, name):
    camera, scene = CAMERAS[name], sa.Scene(suns=SUN)
    with sa.Renderer(ctx, scene, SIZE, SINGLE) as renderer:
        pixels = renderer.render(camera).numpy().reshape(-1, 3)
    rays = camera.pixel_rays(SIZE).reshape(-1, 3)
    truth = reference.probe(scene, np.broadcast_to(camera.position, rays.shape), rays).single
    # the floor is 1e-7 of daylight: a path that is dark in truth may keep a lit decimetre at the top of the air
    error = np.abs(pixels - truth) / np.maximum(truth, max(1e-4 * truth.max(), 1e-8))
    # 20 nodes; at the limb a pixel ray's float32 tangent height is a few metres off from the Moon's distance on
    assert np.percentile(error, 99) < (2e-2 if np.linalg.norm(camera.position) > 1e8 else 5e-3)


@pytest.mark.parametrize("quality", ["balanced", sa.Quality(), sa.Quality(depth_bits=24),
                                     sa.Quality(transmittance="table"), sa.Quality(method="widths"),
                                     sa.Quality(tolerance=0.006)])  # fmt: skip
def test_every_camera_is_finite(ctx, quality):
    r = EARTH.atmosphere.bottom_radius
    odd = {
        "on the ground": level(60, 0.0, 0, 0),
        "a metre below": level(60, -1.0, 0, 0),
        "a millimetre up, straight up": level(60, 1e-3, 0, 89.99),
        "on the top of the air": level(60, EARTH.atmosphere.thickness, 0, -5),
        "at the center": sa.Camera(position=(0, 0, 0), forward=(1, 0, 0)),
        "into the sun from inside the cone": sa.Camera(position=(-2 * r, 0, 0), forward=(1, 0, 0)),
        "along the axis from its middle": sa.Camera(position=(-2 * r, 0, 0), forward=(-1, 0, 0)),
        "on the cylinder's surface": sa.Camera(position=(-r, r, 0), forward=(1, 0, 0)),
        "at the umbra's apex": sa.Camera(position=(-1.383e9, 0, 0), target=(0, 0, 0), vertical_fov=0.02),
        "very far": sa.Camera(position=(1e11, 1e11, 0), target=(0, 0, 0), vertical_fov=1e-3),
    }
    with sa.Renderer(ctx, EARTH, SIZE, quality) as renderer:
        for name, camera in {**CAMERAS, **odd}.items():
            frame = renderer.render(camera)
            for field in ("color", "lit_width", "shadow_width"):
                values = frame.read(field)
                assert np.isfinite(values).all() and (values >= 0).all(), (name, field)
            assert not np.isnan(frame.read("depth")).any(), name


def test_camera_inside_the_shadow_sees_no_cap(ctx):
    """The failure of the paper's figure 11: with the shadow's front behind the camera its width still counts."""
    camera = CAMERAS["2 m, deep night"]
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE) as renderer:
        frame = renderer.render(camera)
        assert frame.read("lit_width").max() < 1.0
        assert frame.read("shadow_width")[0].min() > 1e4


@pytest.mark.parametrize("depth_bits", [32, 24])
def test_camera_in_the_shadow_above_the_air(ctx, depth_bits):
    """Nothing of the shadow's front is in view, in neither kind of depth; the ground's side of it is dark."""
    r = EARTH.atmosphere.bottom_radius
    camera = sa.Camera(position=(-0.2 * r, 0.995 * r, 0), target=(0.3 * r, 0.95 * r, 0), up=(0, 1, 0), vertical_fov=0.7)
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, sa.Quality(depth_bits=depth_bits)) as renderer:
        frame = renderer.render(camera)
        lit, shadow = frame.read("lit_width")[24, 30, 0], frame.read("shadow_width")[24, 30, 0]
    assert shadow > 1e5 and lit < 0.2 * shadow


def test_no_steps_close_to_the_air(ctx):
    """The failure of figure 12: a metre before the top of the air the widths still vary smoothly."""
    top = EARTH.atmosphere.thickness
    before, after = level(60, top + 1.0, 0, -10, fov=20), level(60, top - 1.0, 0, -10, fov=20)
    with sa.Renderer(ctx, sa.Scene(suns=SUN), (9, 400)) as renderer:
        widths = [renderer.render(camera).read("lit_width")[:, 4, 0] for camera in (before, after)]
    with sa.Renderer(ctx, sa.Scene(suns=SUN), (9, 400), sa.Quality(depth_bits=24)) as renderer:
        stepped = renderer.render(before).read("lit_width")[:, 4, 0]
    ground = slice(250, 400)
    assert np.abs(widths[0] - widths[1])[ground].max() < 100.0
    bends = [np.abs(np.diff(w[ground], 2)).max() for w in (*widths, stepped)]
    assert bends[0] < 100.0 and bends[1] < 100.0 and bends[2] > 10 * bends[1]


@pytest.mark.parametrize("size", [(1, 1), (1, 257), (640, 1), (33, 17), (1283, 719)])
def test_every_size(ctx, size):
    with sa.Renderer(ctx, EARTH, size, "fast") as renderer:
        frame = renderer.render(CAMERA)
        assert frame.numpy().shape == (size[1], size[0], 3) and frame.numpy().dtype == np.float32
        assert np.isfinite(frame.numpy()).all()
        assert frame.image().size == size


def test_largest_size(ctx):
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    with sa.Renderer(ctx, sa.Scene(suns=SUN), (min(limit, 16384), 2), "fast") as renderer:
        assert np.isfinite(renderer.render(CAMERA).numpy()).all()
    with pytest.raises(sa.ParameterError, match="size"):
        sa.Renderer(ctx, sa.Scene(suns=SUN), (limit + 1, 2))


def test_row_0_is_the_top(ctx):
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE) as renderer:
        pixels = renderer.render(level(60, 2.0, 0, 0)).numpy()
    assert pixels[0].sum() > 0 and pixels[:15].mean() != pixels[-15:].mean()
    camera = level(60, 2.0, 0, 0)
    assert reference.lengths(sa.Scene(suns=SUN), camera.position, camera.pixel_rays(SIZE)[0, 0]).end[0] == "top"


def test_suns_add_up(ctx):
    second = sa.Sun(direction=(0, 1, 0.3), irradiance=(0.2, 0.1, 0.05))
    camera = CAMERAS["20 000 km, half phase"]
    frames = []
    for suns in ((SUN,), (second,), (SUN, second)):
        with sa.Renderer(ctx, sa.Scene(suns=suns), SIZE) as renderer:
            frames.append(renderer.render(camera).numpy().astype(float))
    assert np.allclose(frames[0] + frames[1], frames[2], rtol=1e-5, atol=1e-9)
    assert frames[1].max() > 1e-3


def test_same_call_same_bits(ctx):
    with sa.Renderer(ctx, EARTH, SIZE) as renderer:
        first = renderer.render(CAMERA).numpy()
        renderer.render(CAMERAS["2 m, noon"])
        assert np.array_equal(renderer.render(CAMERA).numpy(), first)


def test_quality_does_not_change_under_a_renderer(ctx):
    with sa.Renderer(ctx, sa.Scene(suns=SUN), (16, 9), "fast") as renderer:
        with pytest.raises(AttributeError):
            renderer.quality = "accurate"
        assert renderer.quality == sa.quality.NAMED["fast"]


def test_scene_may_change_between_frames(ctx):
    with sa.Renderer(ctx, EARTH, SIZE) as renderer:
        day = renderer.render(CAMERA).numpy()
        renderer.scene = EARTH.with_sun_direction((-1, 0, 0))
        night = renderer.render(CAMERA).numpy()
        assert night.max() < 1e-2 * day.max()
        renderer.scene = dataclasses.replace(EARTH, surface=None)
        assert not np.allclose(renderer.render(CAMERA).numpy(), day)
        renderer.scene = EARTH
        assert np.array_equal(renderer.render(CAMERA).numpy(), day)


def test_host_state_comes_back(ctx):
    with sa.Renderer(ctx, EARTH, SIZE) as renderer, preserve_state(ctx):
        plain = renderer.render(CAMERA).numpy()
        host = HostObjects(ctx)
        host.make_hostile()
        before = snapshot(ctx)
        hostile = renderer.render(CAMERA)
        assert difference(before, snapshot(ctx)) == set()
        pixels, picture = hostile.numpy(), hostile.image()
        probed = sa.probe(ctx, EARTH, CAMERA.position, CAMERA.forward)
        assert difference(before, snapshot(ctx)) == set()
        assert np.array_equal(pixels, plain) and picture.size == SIZE and np.isfinite(probed.single).all()
    host.release()


def textures(ctx, size=SIZE, depth_value=np.inf, color=(0.2, 0.1, 0.05)):
    pixels = np.broadcast_to(np.float32([*color, 1.0]), (*size[::-1], 4))
    depths = np.full((*size[::-1], 1), depth_value, np.float32)
    return ctx.texture(size, 4, pixels.tobytes(), dtype="f4"), ctx.texture(size, 1, depths.tobytes(), dtype="f4")


def test_compose_dims_and_veils(ctx):
    camera = CAMERAS["2 m, noon"]
    color, depth = textures(ctx, depth_value=2e4)
    rays = camera.pixel_rays(SIZE).reshape(-1, 3)
    scene = sa.Scene(suns=SUN)
    truth = reference.probe(scene, np.broadcast_to(camera.position, rays.shape), rays, t_max=2e4)
    with sa.Renderer(ctx, scene, SIZE, SINGLE) as renderer:
        target = ctx.simple_framebuffer(SIZE, 4, dtype="f4")
        frame = renderer.compose(color, depth, camera, target=target)
        composed = frame.numpy().reshape(-1, 3)
        want = truth.transmittance * (0.2, 0.1, 0.05) + truth.single
        assert np.max(np.abs(composed / want - 1)) < 2e-3
        drawn = np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(*SIZE[::-1], 3)[::-1]
        assert np.array_equal(drawn, frame.numpy())
        by_name = renderer.compose(color.glo, depth.glo, camera).numpy()
        assert np.array_equal(by_name.reshape(-1, 3), composed)
        # what a renderer drew composes to the same path again
        own = renderer.render(camera)
        again = renderer.compose(color, own.depth, camera)
        assert again.read("lit_width").max() > 1e5
        target.release()
    color.release()
    depth.release()


def test_compose_reads_depth_attachments(ctx):
    """A host's own z-buffer: 24-bit, standard, with its comparison mode on."""
    color, _ = textures(ctx)
    z = ctx.depth_texture(SIZE)
    framebuffer = ctx.framebuffer([], z)
    framebuffer.clear(depth=1.0 - 1.0 / 1e3)  # near 1 m, far infinite: 1 km away
    camera = dataclasses.replace(CAMERAS["2 m, noon"], target=None, depth=DepthConvention("standard", near=1.0))
    with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE) as renderer:
        width = renderer.compose(color, z, camera).read("lit_width")
        assert abs(width[10, 30, 0] - 1e3) < 60.0  # near the axis; a 24-bit step is worth 60 m * 1e-3 there
        with pytest.raises(sa.ParameterError, match=r"camera\.depth"):
            renderer.compose(color, z, CAMERAS["2 m, noon"])
    for item in (framebuffer, z, color):
        item.release()


def test_bad_input_draws_nothing(ctx):
    color, depth = textures(ctx)
    small, small_depth = textures(ctx, (8, 8))
    with sa.Renderer(ctx, EARTH, SIZE) as renderer:
        kept = renderer.render(CAMERA)
        before = kept.numpy()
        for call, name in (
            (lambda: renderer.compose(small, depth, CAMERA), "color"),
            (lambda: renderer.compose(color, small_depth, CAMERA), "depth"),
            (lambda: renderer.compose(color, None, CAMERA), "depth"),
            (lambda: renderer.compose(color, depth, None), "camera"),
            (lambda: renderer.compose(color, depth, CAMERA, target=ctx.simple_framebuffer((8, 8))), "target"),
            (lambda: renderer.render("camera"), "camera"),
            (lambda: setattr(renderer, "scene", None), "scene"),
            (lambda: kept.image(exposure=0.0), "exposure"),
            (lambda: sa.Renderer(ctx, EARTH, (0, 10)), "size"),
            (lambda: sa.Renderer(ctx, EARTH, (10.5, 10)), "size"),
            (lambda: sa.Renderer(ctx, EARTH, SIZE, "superb"), "quality"),
            (lambda: sa.Renderer(ctx, "earth", SIZE), "scene"),
        ):
            with pytest.raises(sa.ParameterError, match=name):
                call()
        assert np.array_equal(kept.numpy(), before)
    for texture in (color, depth, small, small_depth):
        texture.release()


def test_closed_renderer_and_stale_frame(ctx):
    renderer = sa.Renderer(ctx, EARTH, SIZE)
    first = renderer.render(CAMERA)
    renderer.render(CAMERA)
    with pytest.raises(sa.PassError, match="gone"):
        first.numpy()
    renderer.close()
    renderer.close()
    with pytest.raises(sa.PassError, match="closed"):
        renderer.render(CAMERA)


def test_a_texture_left_bound_does_no_harm_on_closing(ctx):
    renderer = sa.Renderer(ctx, EARTH, SIZE)
    renderer.render(CAMERA).color.use(3)
    renderer.close()
    assert ctx.error == "GL_NO_ERROR"
    with sa.Renderer(ctx, EARTH, SIZE) as renderer:
        assert renderer.render(CAMERA).numpy().max() > 0
    ctx.clear_errors()


def test_what_is_approximated_is_said(ctx, caplog):
    scene = sa.Scene(suns=dataclasses.replace(SUN, disc_at_terminator=True))
    quality = sa.Quality(method="widths", orders=1)
    with sa.Renderer(ctx, scene, SIZE, quality) as renderer:
        assert "disc_at_terminator: left out" in str(renderer.plan)
        renderer.scene = EARTH
        renderer.scene = scene
    assert sum("disc_at_terminator" in record.message for record in caplog.records) == 2
    caplog.clear()
    for shown, chosen in ((EARTH, quality), (scene, sa.Quality(orders=1))):
        with sa.Renderer(ctx, shown, SIZE, chosen):
            assert not caplog.records


def test_plan_says_what_runs_and_why(ctx):
    with sa.Renderer(ctx, sa.Scene(), SIZE, sa.Quality(depth="analytic", orders=1)) as renderer:
        plan = renderer.plan
        assert [s.name for s in plan.steps] == ["widths", "atmosphere"]
        assert "planet" in str(plan) and "left out" in str(plan)
        assert set(plan.steps[0].inputs) == set()
    with sa.Renderer(ctx, EARTH, SIZE, sa.Quality(depth="textures")) as renderer:
        names = [s.name for s in renderer.plan.steps]
        assert {"multiple", "multiple_view"} <= set(names)
        five = ["shadow_back_depth", "shadow_front_depth", "planet", "atmosphere_back_depth", "widths", "atmosphere"]
        assert [n for n in names if n in five] == five
        assert not renderer.plan.check_inputs(())
        assert all(step.reason for step in renderer.plan.steps)
