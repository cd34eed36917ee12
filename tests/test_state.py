"""The state guard: hostile state in, a right picture inside, every value back.

The list of values read here is written out on its own, not taken from the guard, so that a piece of state the guard
forgets shows up as a difference.
"""

import ctypes

import moderngl
import numpy as np
import pytest

from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, release_programs
from shadowatmo.passes.gl.state import preserve_state, state_items
from shadowatmo.passes.gl.textures import Target

FLAGS = {
    "BLEND": 0x0BE2, "DEPTH_TEST": 0x0B71, "CULL_FACE": 0x0B44, "STENCIL_TEST": 0x0B90, "SCISSOR_TEST": 0x0C11,
    "POLYGON_OFFSET_FILL": 0x8037, "POLYGON_OFFSET_LINE": 0x2A02, "POLYGON_OFFSET_POINT": 0x2A01,
    "FRAMEBUFFER_SRGB": 0x8DB9, "RASTERIZER_DISCARD": 0x8C89, "PRIMITIVE_RESTART": 0x8F9D,
    "PRIMITIVE_RESTART_FIXED_INDEX": 0x8D69, "SAMPLE_ALPHA_TO_COVERAGE": 0x809E, "SAMPLE_ALPHA_TO_ONE": 0x809F,
    "SAMPLE_COVERAGE": 0x80A0, "SAMPLE_MASK": 0x8E51, "COLOR_LOGIC_OP": 0x0BF2, "DEPTH_CLAMP": 0x864F,
    "PROGRAM_POINT_SIZE": 0x8642, "LINE_SMOOTH": 0x0B20, "POLYGON_SMOOTH": 0x0B41, "SAMPLE_SHADING": 0x8C36,
    **{f"CLIP_DISTANCE{index}": 0x3000 + index for index in range(8)}, "MULTISAMPLE": 0x809D, "DITHER": 0x0BD0,
    "TEXTURE_CUBE_MAP_SEAMLESS": 0x884F,
}
ON_BY_DEFAULT = {"MULTISAMPLE", "TEXTURE_CUBE_MAP_SEAMLESS"}  # the second by moderngl
LATER = {"PRIMITIVE_RESTART_FIXED_INDEX": 430, "SAMPLE_SHADING": 400}

INTEGERS = {
    "CURRENT_PROGRAM": (0x8B8D, 1), "VERTEX_ARRAY": (0x85B5, 1), "DRAW_FRAMEBUFFER": (0x8CA6, 1),
    "READ_FRAMEBUFFER": (0x8CAA, 1), "RENDERBUFFER": (0x8CA7, 1), "VIEWPORT": (0x0BA2, 4),
    "SCISSOR_BOX": (0x0C10, 4), "ACTIVE_TEXTURE": (0x84E0, 1), "ARRAY_BUFFER": (0x8894, 1),
    "UNIFORM_BUFFER": (0x8A28, 1), "PIXEL_PACK_BUFFER": (0x88ED, 1), "PIXEL_UNPACK_BUFFER": (0x88EF, 1),
    "COPY_READ_BUFFER": (0x8F36, 1), "COPY_WRITE_BUFFER": (0x8F37, 1),
    "BLEND_SRC_RGB": (0x80C9, 1), "BLEND_DST_RGB": (0x80C8, 1), "BLEND_SRC_ALPHA": (0x80CB, 1),
    "BLEND_DST_ALPHA": (0x80CA, 1), "BLEND_EQUATION_RGB": (0x8009, 1), "BLEND_EQUATION_ALPHA": (0x883D, 1),
    "DEPTH_FUNC": (0x0B74, 1), "DEPTH_WRITEMASK": (0x0B72, 1), "CULL_FACE_MODE": (0x0B45, 1),
    "FRONT_FACE": (0x0B46, 1), "STENCIL_FUNC": (0x0B92, 1), "STENCIL_REF": (0x0B97, 1),
    "STENCIL_VALUE_MASK": (0x0B93, 1), "STENCIL_WRITEMASK": (0x0B98, 1), "STENCIL_FAIL": (0x0B94, 1),
    "STENCIL_PASS_DEPTH_FAIL": (0x0B95, 1), "STENCIL_PASS_DEPTH_PASS": (0x0B96, 1),
    "STENCIL_BACK_FUNC": (0x8800, 1), "STENCIL_BACK_REF": (0x8CA3, 1), "STENCIL_BACK_VALUE_MASK": (0x8CA4, 1),
    "STENCIL_BACK_WRITEMASK": (0x8CA5, 1), "STENCIL_BACK_FAIL": (0x8801, 1),
    "STENCIL_BACK_PASS_DEPTH_FAIL": (0x8802, 1), "STENCIL_BACK_PASS_DEPTH_PASS": (0x8803, 1),
    "STENCIL_CLEAR_VALUE": (0x0B91, 1), "POLYGON_MODE": (0x0B40, 1), "PRIMITIVE_RESTART_INDEX": (0x8F9E, 1),
    "PROVOKING_VERTEX": (0x8E4F, 1), "CLAMP_READ_COLOR": (0x891C, 1), "LOGIC_OP_MODE": (0x0BF0, 1),
    "SAMPLE_COVERAGE_INVERT": (0x80AB, 1), "DRAW_BUFFER0": (0x8825, 1), "DRAW_BUFFER1": (0x8826, 1),
    "READ_BUFFER": (0x0C02, 1),
    **{f"UNPACK_{enum:04x}": (enum, 1) for enum in (*range(0x0CF0, 0x0CF6), 0x806D, 0x806E)},
    **{f"PACK_{enum:04x}": (enum, 1) for enum in (*range(0x0D00, 0x0D06), 0x806B, 0x806C)},
}
FLOATS = {
    "BLEND_COLOR": (0x8005, 4), "COLOR_CLEAR_VALUE": (0x0C22, 4), "DEPTH_CLEAR_VALUE": (0x0B73, 1),
    "DEPTH_RANGE": (0x0B70, 2), "POLYGON_OFFSET_FACTOR": (0x8038, 1), "POLYGON_OFFSET_UNITS": (0x2A00, 1),
    "LINE_WIDTH": (0x0B21, 1), "POINT_SIZE": (0x0B11, 1), "SAMPLE_COVERAGE_VALUE": (0x80AA, 1),
}
TEXTURE_QUERIES = {"2D": 0x8069, "3D": 0x806A, "2D_ARRAY": 0x8C1D, "CUBE": 0x8514, "SAMPLER": 0x8919}
TEXTURE_TARGETS = {"2D": 0x0DE1, "3D": 0x806F, "2D_ARRAY": 0x8C1A, "CUBE": 0x8513}


def flags_of(ctx):
    return {name: enum for name, enum in FLAGS.items() if ctx.version_code >= LATER.get(name, 330)}


def snapshot(ctx):
    """Everything the guard promises, by name."""
    gl = gl_functions(ctx)
    state = {name: gl.IsEnabled(enum) for name, enum in flags_of(ctx).items()}
    state |= {name: gl.integers(enum, count) for name, (enum, count) in INTEGERS.items()}
    state |= {name: gl.floats(enum, count) for name, (enum, count) in FLOATS.items()}
    box, flags, wide = (ctypes.c_int * 16)(), (ctypes.c_ubyte * 16)(), (ctypes.c_int64 * 16)()
    for index in range(4):
        gl.GetBooleani_v(0x0C23, index, flags)
        state[f"COLOR_WRITEMASK{index}"] = tuple(flags[:4])
        state[f"BLEND{index}"] = gl.IsEnabledi(0x0BE2, index)
        gl.GetIntegeri_v(0x8A28, index, box)
        state[f"UNIFORM_BUFFER{index}"] = box[0]
        for name, enum in (("START", 0x8A29), ("SIZE", 0x8A2A)):
            gl.GetInteger64i_v(enum, index, wide)
            state[f"UNIFORM_BUFFER_{name}{index}"] = wide[0]
    if gl.has("BlendFuncSeparatei"):
        for index in range(2):
            for name, enum in (("SRC_RGB", 0x80C9), ("DST_ALPHA", 0x80CA), ("EQUATION_RGB", 0x8009)):
                gl.GetIntegeri_v(enum, index, box)
                state[f"BLEND_{name}{index}"] = box[0]
    if gl.has("ClipControl"):
        state["CLIP_CONTROL"] = (gl.integer(0x935C), gl.integer(0x935D))
    if gl.has("GetFloati_v"):
        reals = (ctypes.c_float * 16)()
        for index in (0, 3):
            gl.GetFloati_v(0x0BA2, index, reals)
            state[f"VIEWPORT{index}"] = tuple(reals[:4])
            gl.GetFloati_v(0x0B70, index, reals)
            state[f"DEPTH_RANGE{index}"] = tuple(reals[:2])
            state[f"SCISSOR_TEST{index}"] = gl.IsEnabledi(0x0C11, index)
    gl.GetIntegeri_v(0x8E52, 0, box)
    state["SAMPLE_MASK_VALUE"] = box[0]
    active = gl.integer(0x84E0)
    for unit in (*range(16), ctx.default_texture_unit):
        gl.ActiveTexture(0x84C0 + unit)
        state |= {f"TEXTURE{unit}_{name}": gl.integer(enum) for name, enum in TEXTURE_QUERIES.items()}
    gl.ActiveTexture(active)
    return state


def difference(before, after):
    """Names whose values differ."""
    assert before.keys() == after.keys()
    return {name for name in before if before[name] != after[name]}


def generate(gl, kind, count=1):
    names = (ctypes.c_uint * count)()
    getattr(gl, f"Gen{kind}")(count, names)
    return list(names)


def delete(gl, kind, names):
    getattr(gl, f"Delete{kind}")(len(names), (ctypes.c_uint * len(names))(*names))


class HostObjects:
    """Textures, samplers, buffers and framebuffers of a host that uses raw OpenGL."""

    def __init__(self, ctx):
        self.ctx, self.gl = ctx, gl_functions(ctx)
        self.samplers = generate(self.gl, "Samplers", 2)
        self.buffers = generate(self.gl, "Buffers", 7)
        self.vertex_array = generate(self.gl, "VertexArrays")
        self.renderbuffer = generate(self.gl, "Renderbuffers")
        self.targets = [Target(ctx, (9, 6), ("rgba8", "rgba32f")) for _ in range(2)]
        self.textures = {"2D": ctx.texture((1, 1), 4), "3D": ctx.texture3d((1, 1, 1), 4),
                         "2D_ARRAY": ctx.texture_array((1, 1, 2), 4), "CUBE": ctx.texture_cube((1, 1), 4)}
        self.program = ctx.program(vertex_shader="#version 330 core\nvoid main() { gl_Position = vec4(0.0); }")

        self._attach_stencil()

    def _attach_stencil(self):
        """Stencil references read as 0 while the bound framebuffer has no stencil buffer."""
        load, gl, framebuffer = self.ctx.mglo._context.load_opengl_function, self.gl, self.targets[0].framebuffer
        unsigned, signed = ctypes.c_uint, ctypes.c_int
        storage = ctypes.CFUNCTYPE(None, unsigned, unsigned, signed, signed)(load("glRenderbufferStorage"))
        attach = ctypes.CFUNCTYPE(None, unsigned, unsigned, unsigned, unsigned)(load("glFramebufferRenderbuffer"))
        gl.BindRenderbuffer(0x8D41, self.renderbuffer[0])
        storage(0x8D41, 0x88F0, *framebuffer.size)  # DEPTH24_STENCIL8
        gl.BindFramebuffer(0x8D40, framebuffer.glo)
        attach(0x8D40, 0x821A, 0x8D41, self.renderbuffer[0])
        gl.BindRenderbuffer(0x8D41, 0)
        gl.BindFramebuffer(0x8D40, 0)

    def release(self):
        for kind, names in (("Samplers", self.samplers), ("Buffers", self.buffers),
                            ("VertexArrays", self.vertex_array), ("Renderbuffers", self.renderbuffer)):
            delete(self.gl, kind, names)
        for item in (*self.targets, *self.textures.values(), self.program):
            item.release()

    def make_hostile(self):
        """Set every guarded value to something else than its default, by raw OpenGL."""
        gl = self.gl
        for target, name in zip((0x8892, 0x8A11, 0x8F36, 0x8F37, 0x88EB, 0x88EC), self.buffers[:6], strict=True):
            gl.BindBuffer(target, name)
            gl.BufferData(target, 4096, None, 0x88E4)
        for unit in (*range(16), self.ctx.default_texture_unit):
            gl.ActiveTexture(0x84C0 + unit)
            for kind, target in TEXTURE_TARGETS.items():
                gl.BindTexture(target, self.textures[kind].glo)
            gl.BindSampler(unit, self.samplers[unit % 2])
        gl.ActiveTexture(0x84C0 + 7)
        gl.BindBufferBase(0x8A11, 0, self.buffers[1])
        gl.BindBufferRange(0x8A11, 2, self.buffers[1], 1024, 256)
        gl.BindBuffer(0x8A11, self.buffers[2])
        gl.UseProgram(self.program.glo)
        gl.BindVertexArray(self.vertex_array[0])
        gl.BindRenderbuffer(0x8D41, self.renderbuffer[0])
        gl.BindFramebuffer(0x8CA9, self.targets[0].framebuffer.glo)
        gl.BindFramebuffer(0x8CA8, self.targets[1].framebuffer.glo)
        gl.DrawBuffers(2, (ctypes.c_uint * 2)(0, 0x8CE1))  # the first attachment masked out
        self._hostile_flags()
        self._hostile_values()

    def _hostile_flags(self):
        gl = self.gl
        for name, enum in flags_of(self.ctx).items():
            if name in ON_BY_DEFAULT:
                gl.Disable(enum)
            else:
                gl.Enable(enum)
        gl.Disablei(0x0BE2, 1)  # blending differs from buffer to buffer
        for index in range(4):
            gl.ColorMaski(index, index == 1, 0, index == 2, 0)

    def _hostile_values(self):
        gl = self.gl
        gl.BlendFuncSeparate(0x0306, 0x0304, 0x0302, 0x0301)
        gl.BlendEquationSeparate(0x800A, 0x800B)
        if gl.has("BlendFuncSeparatei"):
            gl.BlendFuncSeparatei(1, 0x0302, 0x0301, 0x0000, 0x0305)
            gl.BlendEquationSeparatei(1, 0x8007, 0x8008)
        gl.BlendColor(0.1, 0.2, 0.3, 0.4)
        gl.DepthFunc(0x0200)  # NEVER
        gl.DepthMask(0)
        gl.DepthRange(0.75, 0.25)
        gl.Viewport(3, 2, 1, 1)
        gl.Scissor(1, 1, 0, 0)
        if gl.has("ViewportArrayv"):
            gl.ViewportArrayv(3, 1, (ctypes.c_float * 4)(0.5, 1.5, 2.5, 3.5))
            gl.DepthRangeArrayv(3, 1, (ctypes.c_double * 2)(0.5, 0.625))
            gl.Disablei(0x0C11, 3)
        gl.CullFace(0x0408)  # FRONT_AND_BACK: nothing is drawn
        gl.FrontFace(0x0900)
        gl.StencilFuncSeparate(0x0404, 0x0200, 3, 0x0F)
        gl.StencilFuncSeparate(0x0405, 0x0202, 5, 0xF0)
        gl.StencilOpSeparate(0x0404, 0x1E01, 0x1E02, 0x1E03)
        gl.StencilOpSeparate(0x0405, 0x1E03, 0x1E01, 0x1E02)
        gl.StencilMaskSeparate(0x0404, 0x3C)
        gl.StencilMaskSeparate(0x0405, 0xC3)
        gl.ClearColor(0.5, 0.25, 0.125, 0.75)
        gl.ClearDepth(0.3125)
        gl.ClearStencil(7)
        gl.PolygonMode(0x0408, 0x1B01)  # LINE
        gl.PolygonOffset(3.0, 5.0)
        gl.PrimitiveRestartIndex(2)
        gl.SampleCoverage(0.25, 1)
        gl.SampleMaski(0, 0x5)
        gl.LogicOp(0x1500)  # CLEAR
        gl.LineWidth(1.0)
        gl.PointSize(3.0)
        gl.ProvokingVertex(0x8E4D)
        gl.ClampColor(0x891C, 1)
        if gl.has("ClipControl"):
            gl.ClipControl(0x8CA2, 0x935F)
        for enum in (0x0CF0, 0x0CF1, 0x0D00, 0x0D01):
            gl.PixelStorei(enum, 1)
        for enum in (0x0CF5, 0x0D05):
            gl.PixelStorei(enum, 8)
        for enum in (0x0CF2, 0x0CF3, 0x0CF4, 0x806D, 0x806E, 0x0D02, 0x0D03, 0x0D04, 0x806B, 0x806C):
            gl.PixelStorei(enum, 3)


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
        right = np.stack([np.full_like(x, -1.5), 0.25 * x, np.full_like(x, 3.0), np.full_like(x, 0.5)], axis=-1)
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
    unused = {f"UNIFORM_BUFFER{suffix}" for suffix in ("1", "3", "_START0", "_START1", "_START3", "_SIZE0", "_SIZE1",
                                                       "_SIZE3")}
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


@pytest.mark.parametrize("name", ["program", "vertex_array", "draw_framebuffer", "viewport", "blend_func", "color_mask",
                                  "depth_mask", "clear_depth", "stencil_mask_back", "pixel_store_0x0d02",
                                  "texture_units", "uniform_buffer_2", "framebuffer_srgb"])
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
@pytest.mark.parametrize("spoil", [
    _cull_everything, _blend_added, lambda gl: gl.Enable(0x8C89), lambda gl: gl.PolygonMode(0x0408, 0x1B01),
    lambda gl: gl.PixelStorei(0x0CF3, 1),
])
def test_the_picture_is_wrong_without_the_guard(ctx, host, painting, spoil):
    """Else the hostile state of the test above would prove nothing."""
    assert painting()
    spoil(host.gl)
    assert not painting()
    with preserve_state(ctx):
        assert painting()


@pytest.mark.parametrize(("call", "name"), [
    (lambda gl: gl.Enable(0x8DB9), "FRAMEBUFFER_SRGB"),
    (lambda gl: gl.DepthMask(0), "DEPTH_WRITEMASK"),
    (lambda gl: gl.BindSampler(11, 0), "TEXTURE11_SAMPLER"),
    (lambda gl: gl.PixelStorei(0x0D05, 2), "PACK_0d05"),
    (lambda gl: gl.ColorMaski(2, 0, 1, 1, 1), "COLOR_WRITEMASK2"),
    (lambda gl: gl.ClearDepth(0.25), "DEPTH_CLEAR_VALUE"),
])
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
    assert (state["CULL_FACE_MODE"], state["FRONT_FACE"], state["POLYGON_MODE"]) == ((0x0405,), (0x0901,), (0x1B02,))
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
    vertex = ("#version 330 core\nvoid main() { vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);\n"
              "gl_Position = vec4(2.0 * p - 1.0, 0.0, 1.0); }\n")
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
