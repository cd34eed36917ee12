"""Render targets: formats, sizes, both depths, reading back, and nothing left when construction fails."""

import numpy as np
import pytest

from shadowatmo.errors import ContextError, ParameterError
from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.shader import (
    Fullscreen,
    bind_textures,
    build_program,
    release_programs,
    set_uniforms,
)
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import COLOR_FORMATS, Target

WRITE = """#version 330 core
uniform float u_depth;
uniform vec4 u_color;
out vec4 color;
void main() { color = u_color; gl_FragDepth = u_depth; }
"""
READ = """#version 330 core
uniform sampler2D u_source;
out vec4 color;
void main() { color = texelFetch(u_source, ivec2(gl_FragCoord.xy), 0); }
"""


@pytest.fixture
def shaders(ctx, tmp_path, monkeypatch):
    from shadowatmo.passes.gl.source import read_shader

    (tmp_path / "fullscreen.vert").write_text(read_shader("fullscreen.vert"))
    (tmp_path / "write.frag").write_text(WRITE)
    (tmp_path / "read.frag").write_text(READ)
    monkeypatch.setenv("SHADOWATMO_SHADER_DIR", str(tmp_path))
    yield ctx
    release_programs(ctx)


def draw_depth(ctx, target, value, func):
    """Draw one full-screen triangle at depth `value` with the depth test `func`."""
    program = build_program(ctx, "write.frag")
    set_uniforms(program, {"u_depth": value, "u_color": (0.25, 0.5, 0.75, 1.0)})
    target.framebuffer.use()
    ctx.enable_only(ctx.DEPTH_TEST)
    ctx.depth_func = func
    full = Fullscreen(ctx, program)
    full.draw()
    full.release()


# 0.25, 0.5 and 0.75 are exact in all float formats; rgba8 rounds to 255 steps, plus the rounding of the
# scaling
@pytest.mark.parametrize(
    ("form", "tolerance"), [(f, 0.501 / 255 if f == "rgba8" else 0.0) for f in COLOR_FORMATS]
)
@pytest.mark.parametrize("size", [(1, 1), (7, 5), (3, 64)])
def test_color_formats(shaders, form, tolerance, size):
    ctx = shaders
    with preserve_state(ctx), Target(ctx, size, (form,)) as target:
        draw_depth(ctx, target, 0.5, "<=")
        pixels = target.read_color()
        components = COLOR_FORMATS[form][0]
        assert pixels.shape == (size[1], size[0], components)
        np.testing.assert_allclose(
            pixels, np.broadcast_to([0.25, 0.5, 0.75, 1.0][:components], pixels.shape), rtol=0, atol=tolerance
        )


# a float keeps 1e-12 to 24 bits; the normalized depth has steps of 2**-24 and may round either way
@pytest.mark.parametrize(
    ("depth", "value", "tolerance"),
    [("d32f", 1e-12, 1e-19), ("d32f", 0.625, 0.0), ("d24", 0.625, 2.0**-24), ("d24", 1e-6, 2.0**-24)],
)
@pytest.mark.parametrize("color", [("rgba32f",), (), ("r32f", "rgba16f")])
def test_depth_is_stored_and_read(shaders, depth, value, tolerance, color):
    ctx = shaders
    with preserve_state(ctx), Target(ctx, (6, 3), color, depth) as target:
        target.framebuffer.clear(depth=0.0)
        assert np.all(target.read_depth() == 0.0)
        draw_depth(ctx, target, value, ">")  # reversed: nearer is larger
        np.testing.assert_allclose(target.read_depth(), np.full((3, 6), value), rtol=0, atol=tolerance)
        target.framebuffer.clear(depth=1.0)
        draw_depth(ctx, target, value, ">")  # now behind everything
        assert np.all(target.read_depth() == 1.0)


def test_24_bit_depth_loses_what_32_bit_keeps(shaders):
    """The reason for the raw storage: had it stayed 24-bit, this value would be 0."""
    ctx = shaders
    stored = {}
    with preserve_state(ctx):
        for depth in ("d24", "d32f"):
            with Target(ctx, (2, 2), ("r32f",), depth) as target:
                target.framebuffer.clear(depth=0.0)
                draw_depth(ctx, target, 1e-9, ">")
                stored[depth] = target.read_depth()[0, 0]
    assert stored["d24"] == 0.0
    assert stored["d32f"] == pytest.approx(1e-9, rel=1e-6)  # float32 rounding


@pytest.mark.parametrize("depth", ["d24", "d32f"])
def test_depth_can_be_sampled(shaders, depth):
    ctx = shaders
    with (
        preserve_state(ctx),
        Target(ctx, (5, 4), (), depth) as source,
        Target(ctx, (5, 4), ("r32f",)) as target,
    ):
        source.framebuffer.clear(depth=0.0)
        draw_depth(ctx, source, 0.625, ">")
        program = build_program(ctx, "read.frag")
        bind_textures(program, {"u_source": source.depth})
        target.framebuffer.use()
        ctx.enable_only(ctx.NOTHING)
        full = Fullscreen(ctx, program)
        full.draw()
        full.release()
        # 24-bit rounding
        np.testing.assert_allclose(target.read_color()[..., 0], 0.625, rtol=0, atol=2.0**-24)


def test_rows_run_upwards(ctx):
    with preserve_state(ctx), Target(ctx, (3, 2), ("r32f",), "d32f") as target:
        target.framebuffer.clear(red=1.0, depth=1.0)
        target.framebuffer.clear(red=2.0, depth=0.5, viewport=(0, 1, 3, 1))
        assert target.read_color()[:, 0, 0].tolist() == [1.0, 2.0]
        assert target.read_depth()[:, 0].tolist() == [1.0, 0.5]


def test_filters_and_edges(ctx):
    with preserve_state(ctx), Target(ctx, (4, 4), ("r32f", "rgba8"), "d32f") as target:
        for texture in (*target.color, target.depth):
            assert texture.filter == (ctx.NEAREST, ctx.NEAREST)
            assert not texture.repeat_x and not texture.repeat_y
        assert target.depth.compare_func == "?" or not target.depth.compare_func
        assert target.bytes == 4 * 4 * (4 + 4 + 4)


def test_the_driver_limit_itself_works(ctx):
    limit = gl_functions(ctx).integer(0x0D33)  # GL_MAX_TEXTURE_SIZE
    with preserve_state(ctx):
        for size in ((limit, 1), (1, limit)):
            with Target(ctx, size, ("rgba8",), "d32f") as target:
                assert target.framebuffer.size == size


@pytest.mark.parametrize(
    "size",
    [
        (0, 4),
        (4, 0),
        (-1, 4),
        (4.0, 4),
        (True, 4),
        (10**9, 4),
        4,
        None,
        (4,),
        (4, 4, 4),
        ("4", 4),
        (float("nan"), 4),
    ],
)
def test_bad_sizes(ctx, size):
    with pytest.raises(ParameterError, match=r"size = .*expected \(width, height\)") as info:
        Target(ctx, size)
    assert info.value.name == "size"


@pytest.mark.parametrize(
    ("kwargs", "name"),
    [({"color": ("rgb9",)}, "color"), ({"color": ()}, "color"), ({"depth": "d16"}, "depth")],
)
def test_bad_formats(ctx, kwargs, name):
    with pytest.raises(ParameterError) as info:
        Target(ctx, (2, 2), **kwargs)
    assert info.value.name == name


def test_numpy_sizes_are_fine(ctx):
    with preserve_state(ctx), Target(ctx, np.array([3, 2])) as target:
        assert target.size == (3, 2)


def test_read_depth_without_depth(ctx):
    with preserve_state(ctx), Target(ctx, (2, 2)) as target, pytest.raises(ParameterError, match="depth"):
        target.read_depth()


@pytest.mark.parametrize("failing", ["_depth_texture", "framebuffer"])
def test_nothing_is_left_when_construction_fails(ctx, monkeypatch, failing):
    made = []
    real_color, real_depth = Target._color_texture, Target._depth_texture

    def remember(make):
        def wrapped(self, argument):
            made.append(make(self, argument))
            return made[-1]

        return wrapped

    def fail(*_):
        raise RuntimeError("as if the driver had refused")

    with preserve_state(ctx):
        monkeypatch.setattr(Target, "_color_texture", remember(real_color))
        monkeypatch.setattr(
            Target, "_depth_texture", fail if failing == "_depth_texture" else remember(real_depth)
        )
        if failing == "framebuffer":
            monkeypatch.setattr(ctx, "framebuffer", fail)
        with pytest.raises(RuntimeError, match="refused"):
            Target(ctx, (8, 8), ("r32f", "rgba16f"), "d32f")
    gl = gl_functions(ctx)
    assert len(made) == (2 if failing == "_depth_texture" else 3)
    assert not any(gl.IsTexture(texture.glo) for texture in made)


def test_release_twice_and_while_bound(ctx):
    """moderngl goes on binding the framebuffer it used last; releasing ours must not leave it a dead name."""
    with preserve_state(ctx):
        target = Target(ctx, (2, 2), ("r32f",))
        target.framebuffer.use()
        target.release()
        target.release()
        with Target(ctx, (2, 2), ("r32f",)):
            assert ctx.error == "GL_NO_ERROR"


def test_released_context_is_named():
    with pytest.raises(ContextError, match="None"):
        Target(None, (2, 2))
