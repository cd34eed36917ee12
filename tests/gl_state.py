"""Read and spoil OpenGL state, written out apart from the guard, so that what the guard forgets shows up."""

import ctypes

from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.textures import Target

FLAGS = {
    "BLEND": 0x0BE2,
    "DEPTH_TEST": 0x0B71,
    "CULL_FACE": 0x0B44,
    "STENCIL_TEST": 0x0B90,
    "SCISSOR_TEST": 0x0C11,
    "POLYGON_OFFSET_FILL": 0x8037,
    "POLYGON_OFFSET_LINE": 0x2A02,
    "POLYGON_OFFSET_POINT": 0x2A01,
    "FRAMEBUFFER_SRGB": 0x8DB9,
    "RASTERIZER_DISCARD": 0x8C89,
    "PRIMITIVE_RESTART": 0x8F9D,
    "PRIMITIVE_RESTART_FIXED_INDEX": 0x8D69,
    "SAMPLE_ALPHA_TO_COVERAGE": 0x809E,
    "SAMPLE_ALPHA_TO_ONE": 0x809F,
    "SAMPLE_COVERAGE": 0x80A0,
    "SAMPLE_MASK": 0x8E51,
    "COLOR_LOGIC_OP": 0x0BF2,
    "DEPTH_CLAMP": 0x864F,
    "PROGRAM_POINT_SIZE": 0x8642,
    "LINE_SMOOTH": 0x0B20,
    "POLYGON_SMOOTH": 0x0B41,
    "SAMPLE_SHADING": 0x8C36,
    **{f"CLIP_DISTANCE{index}": 0x3000 + index for index in range(8)},
    "MULTISAMPLE": 0x809D,
    "DITHER": 0x0BD0,
    "TEXTURE_CUBE_MAP_SEAMLESS": 0x884F,
}
ON_BY_DEFAULT = {"MULTISAMPLE", "TEXTURE_CUBE_MAP_SEAMLESS"}  # the second by moderngl
LATER = {"PRIMITIVE_RESTART_FIXED_INDEX": 430, "SAMPLE_SHADING": 400}

INTEGERS = {
    "CURRENT_PROGRAM": (0x8B8D, 1),
    "VERTEX_ARRAY": (0x85B5, 1),
    "DRAW_FRAMEBUFFER": (0x8CA6, 1),
    "READ_FRAMEBUFFER": (0x8CAA, 1),
    "RENDERBUFFER": (0x8CA7, 1),
    "VIEWPORT": (0x0BA2, 4),
    "SCISSOR_BOX": (0x0C10, 4),
    "ACTIVE_TEXTURE": (0x84E0, 1),
    "ARRAY_BUFFER": (0x8894, 1),
    "UNIFORM_BUFFER": (0x8A28, 1),
    "PIXEL_PACK_BUFFER": (0x88ED, 1),
    "PIXEL_UNPACK_BUFFER": (0x88EF, 1),
    "COPY_READ_BUFFER": (0x8F36, 1),
    "COPY_WRITE_BUFFER": (0x8F37, 1),
    "BLEND_SRC_RGB": (0x80C9, 1),
    "BLEND_DST_RGB": (0x80C8, 1),
    "BLEND_SRC_ALPHA": (0x80CB, 1),
    "BLEND_DST_ALPHA": (0x80CA, 1),
    "BLEND_EQUATION_RGB": (0x8009, 1),
    "BLEND_EQUATION_ALPHA": (0x883D, 1),
    "DEPTH_FUNC": (0x0B74, 1),
    "DEPTH_WRITEMASK": (0x0B72, 1),
    "CULL_FACE_MODE": (0x0B45, 1),
    "FRONT_FACE": (0x0B46, 1),
    "STENCIL_FUNC": (0x0B92, 1),
    "STENCIL_REF": (0x0B97, 1),
    "STENCIL_VALUE_MASK": (0x0B93, 1),
    "STENCIL_WRITEMASK": (0x0B98, 1),
    "STENCIL_FAIL": (0x0B94, 1),
    "STENCIL_PASS_DEPTH_FAIL": (0x0B95, 1),
    "STENCIL_PASS_DEPTH_PASS": (0x0B96, 1),
    "STENCIL_BACK_FUNC": (0x8800, 1),
    "STENCIL_BACK_REF": (0x8CA3, 1),
    "STENCIL_BACK_VALUE_MASK": (0x8CA4, 1),
    "STENCIL_BACK_WRITEMASK": (0x8CA5, 1),
    "STENCIL_BACK_FAIL": (0x8801, 1),
    "STENCIL_BACK_PASS_DEPTH_FAIL": (0x8802, 1),
    "STENCIL_BACK_PASS_DEPTH_PASS": (0x8803, 1),
    "STENCIL_CLEAR_VALUE": (0x0B91, 1),
    "POLYGON_MODE": (0x0B40, 1),
    "PRIMITIVE_RESTART_INDEX": (0x8F9E, 1),
    "PROVOKING_VERTEX": (0x8E4F, 1),
    "CLAMP_READ_COLOR": (0x891C, 1),
    "LOGIC_OP_MODE": (0x0BF0, 1),
    "SAMPLE_COVERAGE_INVERT": (0x80AB, 1),
    "DRAW_BUFFER0": (0x8825, 1),
    "DRAW_BUFFER1": (0x8826, 1),
    "READ_BUFFER": (0x0C02, 1),
    **{f"UNPACK_{enum:04x}": (enum, 1) for enum in (*range(0x0CF0, 0x0CF6), 0x806D, 0x806E)},
    **{f"PACK_{enum:04x}": (enum, 1) for enum in (*range(0x0D00, 0x0D06), 0x806B, 0x806C)},
}
FLOATS = {
    "BLEND_COLOR": (0x8005, 4),
    "COLOR_CLEAR_VALUE": (0x0C22, 4),
    "DEPTH_CLEAR_VALUE": (0x0B73, 1),
    "DEPTH_RANGE": (0x0B70, 2),
    "POLYGON_OFFSET_FACTOR": (0x8038, 1),
    "POLYGON_OFFSET_UNITS": (0x2A00, 1),
    "LINE_WIDTH": (0x0B21, 1),
    "POINT_SIZE": (0x0B11, 1),
    "SAMPLE_COVERAGE_VALUE": (0x80AA, 1),
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
        self.textures = {
            "2D": ctx.texture((1, 1), 4),
            "3D": ctx.texture3d((1, 1, 1), 4),
            "2D_ARRAY": ctx.texture_array((1, 1, 2), 4),
            "CUBE": ctx.texture_cube((1, 1), 4),
        }
        self.program = ctx.program(
            vertex_shader="#version 330 core\nvoid main() { gl_Position = vec4(0.0); }"
        )

        self._attach_stencil()

    def _attach_stencil(self):
        """Stencil references read as 0 while the bound framebuffer has no stencil buffer."""
        load, gl, framebuffer = (
            self.ctx.mglo._context.load_opengl_function,
            self.gl,
            self.targets[0].framebuffer,
        )
        unsigned, signed = ctypes.c_uint, ctypes.c_int
        storage = ctypes.CFUNCTYPE(None, unsigned, unsigned, signed, signed)(load("glRenderbufferStorage"))
        attach = ctypes.CFUNCTYPE(None, unsigned, unsigned, unsigned, unsigned)(
            load("glFramebufferRenderbuffer")
        )
        gl.BindRenderbuffer(0x8D41, self.renderbuffer[0])
        storage(0x8D41, 0x88F0, *framebuffer.size)  # DEPTH24_STENCIL8
        gl.BindFramebuffer(0x8D40, framebuffer.glo)
        attach(0x8D40, 0x821A, 0x8D41, self.renderbuffer[0])
        gl.BindRenderbuffer(0x8D41, 0)
        gl.BindFramebuffer(0x8D40, 0)

    def release(self):
        for kind, names in (
            ("Samplers", self.samplers),
            ("Buffers", self.buffers),
            ("VertexArrays", self.vertex_array),
            ("Renderbuffers", self.renderbuffer),
        ):
            delete(self.gl, kind, names)
        for item in (*self.targets, *self.textures.values(), self.program):
            item.release()

    def make_hostile(self):
        """Set every guarded value to something else than its default, by raw OpenGL."""
        gl = self.gl
        for target, name in zip(
            (0x8892, 0x8A11, 0x8F36, 0x8F37, 0x88EB, 0x88EC), self.buffers[:6], strict=True
        ):
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
