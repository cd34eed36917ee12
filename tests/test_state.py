"""The state guard: hostile state in, a right picture inside, every value back.

The list of values read here is written out on its own, not taken from the guard, so that a piece of state the
guard forgets shows up as a difference.
"""

import moderngl
import numpy as np
import pytest

from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, release_programs
from shadowatmo.passes.gl.state import preserve_state, state_items
from shadowatmo.passes.gl.textures import Target
from tests.gl_state import TEXTURE_TARGETS, HostObjects, difference, flags_of, snapshot

PAINT = """#version 330 core
uniform sampler2D u_source;
layout(location = 0) out vec4 first;
layout(location = 1) out vec4 second;
void main() {
    first = vec4(-1.5, 0.25 * gl_FragCoord.x, 3.0, 0.5);
    second = texelFetch(u_source, ivec2(0), 0) + vec4(gl_FragCoord.y);
}
"""
SOURCE_TEXEL = (8.0, -2.0, 0.5, 1.0)


@pytest.fixture
def painting(ctx, tmp_path, monkeypatch):
    """A function that draws with everything of ours and says whether the picture is right."""
    from shadowatmo.passes.gl.source import read_shader

    (tmp_path / "fullscreen.vert").write_text(read_shader("fullscreen.vert"))
    (tmp_path / "paint.frag").write_text(PAINT)
    monkeypatch.setenv("SHADOWATMO_SHADER_DIR", str(tmp_path))

    def paint():
        program = build_program(ctx, "paint.frag")
        texture = ctx.texture((1, 1), 4, np.array(SOURCE_TEXEL, np.float32).tobytes(), dtype="f4")
        full = Fullscreen(ctx, program)
        with Target(ctx, (5, 3), ("rgba32f", "rgba32f"), "d32f") as target:
            target.framebuffer.use()
            target.framebuffer.clear(depth=0.5)
            bind_textures(program, {"u_source": texture})
            full.draw()
            first, second = target.read_color(0), target.read_color(1)
        full.release()
        texture.release()
        y, x = np.mgrid[0:3, 0:5] + 0.5
        right = np.stack(
            [np.full_like(x, -1.5), 0.25 * x, np.full_like(x, 3.0), np.full_like(x, 0.5)], axis=-1
        )
        return np.array_equal(first, right) and np.array_equal(second, np.add.outer(y, SOURCE_TEXEL))

    yield paint
    release_programs(ctx)


@pytest.fixture
def host(ctx):
    """Host objects; whatever the test does to the state is undone at the end."""
    with preserve_state(ctx):
        objects = HostObjects(ctx)
        yield objects
    objects.release()


def test_hostile_state_comes_back(ctx, host, painting):
    default = snapshot(ctx)
    host.make_hostile()
    before = snapshot(ctx)
    # a value that is at its default says nothing about being restored: list the exceptions
    same = {name for name in before if before[name] == default[name]}
    one_size = {"LINE_WIDTH"}  # core profiles may have the width 1 only
    window = {"READ_BUFFER", "DRAW_BUFFER1"}  # per framebuffer, and another one is bound
    unused = {
        f"UNIFORM_BUFFER{suffix}"
        for suffix in ("1", "3", "_START0", "_START1", "_START3", "_SIZE0", "_SIZE1", "_SIZE3")
    }
    per_buffer = {"BLEND1", "SCISSOR_TEST3"}
    # moderngl made the host's textures on this unit, so they are there already
    working_unit = {f"TEXTURE{ctx.default_texture_unit}_{kind}" for kind in TEXTURE_TARGETS}
    assert same - one_size - window - unused - per_buffer - working_unit == set()
    with preserve_state(ctx) as found:
        assert found.framebuffer == host.targets[0].framebuffer.glo
        assert found.viewport == (3, 2, 1, 1)
        assert painting()
    assert difference(before, snapshot(ctx)) == set()


def test_whatever_is_done_inside_is_undone(ctx, host):
    """The other way round: the host has defaults, and the inside changes every value."""
    before = snapshot(ctx)
    with preserve_state(ctx):
        host.make_hostile()
    assert difference(before, snapshot(ctx)) == set()


@pytest.mark.parametrize(
    "name",
    [
        "program",
        "vertex_array",
        "draw_framebuffer",
        "viewport",
        "blend_func",
        "color_mask",
        "depth_mask",
        "clear_depth",
        "stencil_mask_back",
        "pixel_store_0x0d02",
        "texture_units",
        "uniform_buffer_2",
        "framebuffer_srgb",
    ],
)
def test_a_forgotten_item_is_noticed(ctx, host, monkeypatch, name):
    kept = [item for item in state_items(ctx) if item.name != name]
    assert len(kept) == len(state_items(ctx)) - 1

    def guarded(inside):
        before = snapshot(ctx)
        with monkeypatch.context() as patch:
            patch.setitem(context_store(ctx), "state_items", kept)
            guard = preserve_state(ctx)
            guard.__enter__()
        inside()
        guard.__exit__(None, None, None)
        return difference(before, snapshot(ctx))

    with preserve_state(ctx):
        forgotten = guarded(host.make_hostile)
    host.make_hostile()
    # one of the two shows it: moderngl's own restoring hides some from the first
    assert forgotten | guarded(lambda: ctx.detect_framebuffer(0).use())


def test_stencil_reference_survives_a_framebuffer_without_stencil(ctx, host):
    """It reads as 0 then, and must not be written back as such."""
    gl = host.gl
    gl.BindFramebuffer(0x8D40, host.targets[0].framebuffer.glo)
    gl.StencilFuncSeparate(0x0408, 0x0202, 3, 0xFF)
    gl.BindFramebuffer(0x8D40, 0)
    with preserve_state(ctx):
        pass
    gl.BindFramebuffer(0x8D40, host.targets[0].framebuffer.glo)
    assert gl.integer(0x0B97) == gl.integer(0x8CA3) == 3


def _cull_everything(gl):
    gl.Enable(0x0B44)
    gl.CullFace(0x0408)


def _blend_added(gl):
    gl.Enable(0x0BE2)
    gl.BlendFuncSeparate(0, 0, 0, 0)


# one piece at a time: all of them together, unguarded, make the software renderer abort the process
@pytest.mark.parametrize(
    "spoil",
    [
        _cull_everything,
        _blend_added,
        lambda gl: gl.Enable(0x8C89),
        lambda gl: gl.PolygonMode(0x0408, 0x1B01),
        lambda gl: gl.PixelStorei(0x0CF3, 1),
    ],
)
def test_the_picture_is_wrong_without_the_guard(ctx, host, painting, spoil):
    """Else the hostile state of the test above would prove nothing."""
    assert painting()
    spoil(host.gl)
    assert not painting()
    with preserve_state(ctx):
        assert painting()


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda gl: gl.Enable(0x8DB9), "FRAMEBUFFER_SRGB"),
        (lambda gl: gl.DepthMask(0), "DEPTH_WRITEMASK"),
        (lambda gl: gl.BindSampler(11, 0), "TEXTURE11_SAMPLER"),
        (lambda gl: gl.PixelStorei(0x0D05, 2), "PACK_0d05"),
        (lambda gl: gl.ColorMaski(2, 0, 1, 1, 1), "COLOR_WRITEMASK2"),
        (lambda gl: gl.ClearDepth(0.25), "DEPTH_CLEAR_VALUE"),
    ],
)
def test_one_value_not_restored_is_noticed(ctx, host, call, name):
    if name == "TEXTURE11_SAMPLER":
        host.gl.BindSampler(11, host.samplers[0])
    before = snapshot(ctx)
    call(host.gl)
    assert difference(before, snapshot(ctx)) == {name}


def test_the_baseline_inside(ctx, host):
    host.make_hostile()
    with preserve_state(ctx):
        state = snapshot(ctx)
    on = {name for name in flags_of(ctx) if state[name]}
    assert on <= {"MULTISAMPLE", "TEXTURE_CUBE_MAP_SEAMLESS"}  # the two the guard leaves as they are
    assert state["DEPTH_FUNC"] == (0x0201,) and state["DEPTH_WRITEMASK"] == (1,)
    assert state["DEPTH_RANGE"] == (0.0, 1.0)
    assert (state["BLEND_SRC_RGB"], state["BLEND_DST_RGB"]) == ((1,), (0,))
    assert (state["BLEND_EQUATION_RGB"], state["BLEND_EQUATION_ALPHA"]) == ((0x8006,), (0x8006,))
    assert (state["CULL_FACE_MODE"], state["FRONT_FACE"], state["POLYGON_MODE"]) == (
        (0x0405,),
        (0x0901,),
        (0x1B02,),
    )
    assert all(state[f"COLOR_WRITEMASK{index}"] == (1, 1, 1, 1) for index in range(4))
    assert all(state[f"TEXTURE{unit}_SAMPLER"] == 0 for unit in range(16))
    assert state["PIXEL_PACK_BUFFER"] == state["PIXEL_UNPACK_BUFFER"] == (0,)
    assert state.get("CLIP_CONTROL", (0x8CA1, 0x935E)) == (0x8CA1, 0x935E)


def test_restored_after_an_exception(ctx, host):
    host.make_hostile()
    before = snapshot(ctx)
    with pytest.raises(KeyError, match="inside"), preserve_state(ctx):
        ctx.depth_func = ">"
        gl_functions(ctx).Viewport(0, 0, 2, 2)
        raise KeyError("inside")
    assert difference(before, snapshot(ctx)) == set()


def test_draw_buffers_of_the_hosts_framebuffer_come_back(ctx, host):
    """moderngl turns on every attachment of a framebuffer that it uses, as when composing into the host's."""
    host.make_hostile()
    before = snapshot(ctx)
    with preserve_state(ctx) as found:
        ctx.detect_framebuffer(found.framebuffer).use()
        assert host.gl.integer(0x8825) != 0  # DRAW_BUFFER0, which the host had masked out
    assert before["DRAW_BUFFER0"] == (0,)
    assert difference(before, snapshot(ctx)) == set()


def test_a_program_deleted_while_in_use_is_no_error(ctx, painting):
    program = ctx.program(vertex_shader="#version 330 core\nvoid main() { gl_Position = vec4(0.0); }")
    with preserve_state(ctx):
        gl_functions(ctx).UseProgram(program.glo)
        program.release()
        with preserve_state(ctx):
            assert painting()
        assert ctx.error == "GL_NO_ERROR"
        assert gl_functions(ctx).integer(0x8B8D) == 0


def test_guards_nest(ctx, host, painting):
    host.make_hostile()
    before = snapshot(ctx)
    with preserve_state(ctx):
        ctx.enable(ctx.BLEND)
        middle = snapshot(ctx)
        with preserve_state(ctx):
            assert painting()
        assert difference(middle, snapshot(ctx)) == set()
    assert difference(before, snapshot(ctx)) == set()


def test_a_host_that_uses_moderngl_draws_on(ctx, host, painting):
    """moderngl's memory: bound framebuffer, enable flags, depth function and the like."""
    fragment = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(0.25); }\n"
    vertex = (
        "#version 330 core\nvoid main() { vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);\n"
        "gl_Position = vec4(2.0 * p - 1.0, 0.0, 1.0); }\n"
    )
    program = ctx.program(vertex_shader=vertex, fragment_shader=fragment)
    triangle = ctx.vertex_array(program, [])
    with Target(ctx, (4, 4), ("rgba32f",), "d24") as target:
        target.framebuffer.use()
        target.framebuffer.clear(depth=1.0)
        ctx.enable_only(ctx.BLEND | ctx.DEPTH_TEST)
        ctx.blend_func = ctx.ONE, ctx.ONE
        ctx.depth_func, ctx.front_face, ctx.cull_face, ctx.provoking_vertex = "<=", "cw", "front", 0x8E4D
        native = ctx.mglo.fbo
        with preserve_state(ctx):
            ctx.enable_only(ctx.CULL_FACE)
            ctx.depth_func, ctx.front_face, ctx.cull_face, ctx.wireframe = ">", "ccw", "back", True
            ctx.wireframe = False
            ctx.polygon_offset = 1.0, 2.0
            assert painting()
        assert ctx.fbo is target.framebuffer
        assert ctx.mglo.fbo is native
        assert (ctx.mglo.depth_func, ctx.front_face, ctx.cull_face) == ("<=", "cw", "front")
        assert ctx.polygon_offset == (0.0, 0.0)
        assert not ctx.wireframe
        triangle.render(moderngl.TRIANGLES, vertices=3)
        with ctx.scope(target.framebuffer, ctx.NOTHING):
            pass  # leaving it sets the flags that moderngl remembers
        triangle.render(moderngl.TRIANGLES, vertices=3)
        assert np.all(target.read_color() == 0.5)  # two layers, added: blending is on in both
        assert np.all(target.read_depth() == pytest.approx(0.5, abs=2.0**-24))  # 24-bit rounding
    triangle.release()
    program.release()
