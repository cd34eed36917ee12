"""Give the host's OpenGL state back: `preserve_state` records, sets a known baseline, and restores.

moderngl's own `scope` restores a framebuffer and five enable flags, and those only as moderngl last saw them.
A host that talks to OpenGL itself needs everything we or moderngl may touch. One table per context lists it:
each `Item` knows how to read a piece of state, how to write it back, and which value our passes start from.
The list is the one that embedded renderers converge to (ImGui's OpenGL back end is the best known).

What cannot be queried cannot be kept: leave the guard out of active queries, transform feedback and
conditional rendering. A program that was deleted while in use is not in use afterwards.
"""

import ctypes
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

from shadowatmo.passes.gl.context import check_alive, context_store
from shadowatmo.passes.gl.functions import gl_functions

GUARDED_UNITS = 16  # texture units 0..15, plus the one moderngl works on

_BLEND, _ZERO, _ONE, _FUNC_ADD, _LESS, _CCW, _FILL = 0x0BE2, 0, 1, 0x8006, 0x0201, 0x0901, 0x1B02
_FRONT, _BACK, _FRONT_AND_BACK = 0x0404, 0x0405, 0x0408
_LAST_VERTEX = 0x8E4E  # a rasterizer may round differently from another vertex on: same state, same bits
_UNIFORM_BUFFER, _UNIFORM_BUFFER_BINDING, _SAMPLER_BINDING = 0x8A11, 0x8A28, 0x8919
_DRAW_FRAMEBUFFER, _READ_FRAMEBUFFER, _DRAW_BINDING, _READ_BINDING = 0x8CA9, 0x8CA8, 0x8CA6, 0x8CAA
_TEXTURE0, _ACTIVE_TEXTURE, _MAX_DRAW_BUFFERS, _ALL_BITS = 0x84C0, 0x84E0, 0x8824, 0xFFFFFFFF

# texture target -> its binding query: 2D, 3D, 2D array, cube
_TEXTURES = {0x0DE1: 0x8069, 0x806F: 0x806A, 0x8C1A: 0x8C1D, 0x8513: 0x8514}
# buffer target -> its binding query: array, pixel pack, pixel unpack, copy read, copy write
_BUFFERS = {0x8892: 0x8894, 0x88EB: 0x88ED, 0x88EC: 0x88EF, 0x8F36: 0x8F36, 0x8F37: 0x8F37}
# all off in the baseline: depth, cull, stencil, polygon offsets, sRGB, discard, restart, sample coverage
# kinds, logic op, depth clamp, point size, smoothing, dither
_FLAGS = {
    "depth_test": 0x0B71, "cull_face": 0x0B44, "stencil_test": 0x0B90, "polygon_offset_point": 0x2A01,
    "polygon_offset_line": 0x2A02, "polygon_offset_fill": 0x8037, "framebuffer_srgb": 0x8DB9,
    "rasterizer_discard": 0x8C89, "primitive_restart": 0x8F9D, "sample_alpha_to_coverage": 0x809E,
    "sample_alpha_to_one": 0x809F, "sample_coverage": 0x80A0, "sample_mask": 0x8E51, "color_logic_op": 0x0BF2,
    "depth_clamp": 0x864F, "program_point_size": 0x8642, "line_smooth": 0x0B20, "polygon_smooth": 0x0B41,
    "dither": 0x0BD0,
}
_KEPT_FLAGS = {"multisample": 0x809D, "texture_cube_map_seamless": 0x884F}  # left as the host has them
# flag -> (enum, core version, extension) for those OpenGL 3.3 lacks
_LATER_FLAGS = {
    "primitive_restart_fixed_index": (0x8D69, 430, "GL_ARB_ES3_compatibility"),
    "sample_shading": (0x8C36, 400, "GL_ARB_sample_shading"),
}
# unpack and pack: swap bytes, LSB first, row length, skip rows, skip pixels, alignment, image height, skip
# images
_PIXEL_STORE = (0x0CF0, 0x0CF1, 0x0CF2, 0x0CF3, 0x0CF4, 0x0CF5, 0x806E, 0x806D,
                0x0D00, 0x0D01, 0x0D02, 0x0D03, 0x0D04, 0x0D05, 0x806C, 0x806B)
# what moderngl remembers of its own calls and hosts may read back
_TRACKED = ("depth_func", "front_face", "cull_face", "wireframe", "provoking_vertex", "polygon_offset",
            "default_texture_unit")


class Item(NamedTuple):
    """One piece of state: `read()` gives a tuple, `write(values)` sets it; no `baseline` leaves it alone."""

    name: str
    read: object
    write: object
    baseline: tuple | None


@dataclass(frozen=True)
class HostState:
    """What the guard found, for passes that draw into the host's own target.

    Parameters
    ----------
    framebuffer : int
        GL name of the draw framebuffer.
    viewport : (int, int, int, int)
        x, y, width, height in pixels.
    """

    framebuffer: int
    viewport: tuple


def _reader(getter, kind, enum, count):
    buffer = (kind * 16)()

    def read():
        getter(enum, buffer)
        return tuple(buffer[:count])

    return read


def _integers(gl, enum, count=1):
    return _reader(gl.GetIntegerv, ctypes.c_int, enum, count)


def _floats(gl, enum, count=1):
    return _reader(gl.GetFloatv, ctypes.c_float, enum, count)


def _indexed(getter, kind, enum, index, count=1):
    buffer = (kind * 16)()

    def read():
        getter(enum, index, buffer)
        return tuple(buffer[:count])

    return read


def _both(*readers):
    return lambda: tuple(value for read in readers for value in read())


def _call(function, *first):
    return lambda values: function(*first, *values)


def _flag(gl, name, enum, baseline=(0,)):
    enable, disable, is_enabled = gl.Enable, gl.Disable, gl.IsEnabled
    return Item(name, lambda: (is_enabled(enum),),
                lambda values: enable(enum) if values[0] else disable(enum), baseline)


def _flag_items(gl):
    yield from (_flag(gl, name, enum) for name, enum in _FLAGS.items())
    for name, (enum, version, extension) in _LATER_FLAGS.items():
        if gl.supports(version, extension):
            yield _flag(gl, name, enum)
    for name, enum in _KEPT_FLAGS.items():
        yield _flag(gl, name, enum, None)
    for index in range(gl.integer(0x0D32)):  # MAX_CLIP_DISTANCES
        yield _flag(gl, f"clip_distance_{index}", 0x3000 + index)


def _binding_items(gl):
    """Objects bound by name; pixel buffers are unbound, else moderngl's uploads would read from them."""
    # a host may delete the program that is in use; it is gone once another is used, and naming it is an error
    yield Item("program", _integers(gl, 0x8B8D),
               lambda values: gl.UseProgram(values[0] if gl.IsProgram(values[0]) else 0), None)
    yield Item("vertex_array", _integers(gl, 0x85B5), _call(gl.BindVertexArray), None)
    yield Item("renderbuffer", _integers(gl, 0x8CA7), _call(gl.BindRenderbuffer, 0x8D41), None)
    for target, query in _BUFFERS.items():
        unbind = (0,) if target in (0x88EB, 0x88EC) else None
        yield Item(f"buffer_{target:#06x}", _integers(gl, query), _call(gl.BindBuffer, target), unbind)
    for index in range(4):
        yield Item(f"uniform_buffer_{index}",
                   _both(_indexed(gl.GetIntegeri_v, ctypes.c_int, _UNIFORM_BUFFER_BINDING, index),
                         _indexed(gl.GetInteger64i_v, ctypes.c_int64, 0x8A29, index),
                         _indexed(gl.GetInteger64i_v, ctypes.c_int64, 0x8A2A, index)),
                   lambda values, index=index: _bind_uniform_buffer(gl, index, *values), None)
    # after the indexed ones: binding those changes the generic one
    yield Item("uniform_buffer", _integers(gl, _UNIFORM_BUFFER_BINDING),
               _call(gl.BindBuffer, _UNIFORM_BUFFER), None)


def _bind_uniform_buffer(gl, index, name, start, size):
    if size:
        gl.BindBufferRange(_UNIFORM_BUFFER, index, name, start, size)
    else:
        gl.BindBufferBase(_UNIFORM_BUFFER, index, name)


def _framebuffer_items(gl):
    bind = gl.BindFramebuffer
    yield Item("draw_framebuffer", _integers(gl, _DRAW_BINDING), _call(bind, _DRAW_FRAMEBUFFER), None)
    yield Item("read_framebuffer", _integers(gl, _READ_BINDING), _call(bind, _READ_FRAMEBUFFER), None)
    count = gl.integer(_MAX_DRAW_BUFFERS)
    array = (ctypes.c_uint * count)()

    def write_draw_buffers(values):
        if gl.integer(_DRAW_BINDING):  # a window's own buffers are never touched
            array[:] = values
            gl.DrawBuffers(count, array)

    # moderngl turns on every attachment of a framebuffer that it uses
    yield Item("draw_buffers", _both(*(_integers(gl, 0x8825 + index) for index in range(count))),
               write_draw_buffers, None)


def _grouped(name, readers, write_all, write_one, baseline):
    """An item of one tuple per index; one call sets them all where they agree, as they nearly always do."""
    count = len(readers)

    def read():
        return tuple(reader() for reader in readers)

    def write(values):
        if values.count(values[0]) == count:
            write_all(*values[0])
            return
        for index, value in enumerate(values):
            write_one(index, *value)

    return Item(name, read, write, None if baseline is None else (baseline,) * count)


def _grouped_flag(gl, name, enum, count):
    def write_one(index, on):
        (gl.Enablei if on else gl.Disablei)(enum, index)

    readers = [lambda index=index: (gl.IsEnabledi(enum, index),) for index in range(count)]
    return _grouped(name, readers, lambda on: (gl.Enable if on else gl.Disable)(enum), write_one, (0,))


def _output_items(gl):
    """Per draw buffer: blending and color mask."""
    count = gl.integer(_MAX_DRAW_BUFFERS)
    yield _grouped_flag(gl, "blend", _BLEND, count)
    masks = [_indexed(gl.GetBooleani_v, ctypes.c_ubyte, 0x0C23, index, 4) for index in range(count)]
    yield _grouped("color_mask", masks, gl.ColorMask, gl.ColorMaski, (1, 1, 1, 1))
    for name, enums, function, baseline in (
            ("blend_func", (0x80C9, 0x80C8, 0x80CB, 0x80CA), "BlendFuncSeparate", (_ONE, _ZERO, _ONE, _ZERO)),
            ("blend_equation", (0x8009, 0x883D), "BlendEquationSeparate", (_FUNC_ADD, _FUNC_ADD))):
        if gl.has(function + "i"):
            readers = [_both(*(_indexed(gl.GetIntegeri_v, ctypes.c_int, enum, index) for enum in enums))
                       for index in range(count)]
            yield _grouped(name, readers, getattr(gl, function), getattr(gl, function + "i"), baseline)
        else:
            read = _both(*(_integers(gl, enum) for enum in enums))
            yield Item(name, read, _call(getattr(gl, function)), baseline)
    yield Item("blend_color", _floats(gl, 0x8005, 4), _call(gl.BlendColor), None)


def _viewport_items(gl):
    """Viewports, scissors, depth ranges: all where the context has arrays, for glViewport sets all."""
    if not gl.has("ViewportArrayv"):
        yield Item("viewport", _integers(gl, 0x0BA2, 4), _call(gl.Viewport), None)
        yield Item("scissor_box", _integers(gl, 0x0C10, 4), _call(gl.Scissor), None)
        yield Item("depth_range", _reader(gl.GetDoublev, ctypes.c_double, 0x0B70, 2),
                   _call(gl.DepthRange), (0.0, 1.0))
        yield _flag(gl, "scissor_test", 0x0C11)
        return
    count = gl.integer(0x825B)  # MAX_VIEWPORTS
    for name, getter, kind, enum, size, setter, baseline in (
            ("viewport", gl.GetFloati_v, ctypes.c_float, 0x0BA2, 4, gl.ViewportArrayv, None),
            ("scissor_box", gl.GetIntegeri_v, ctypes.c_int, 0x0C10, 4, gl.ScissorArrayv, None),
            ("depth_range", gl.GetDoublei_v, ctypes.c_double, 0x0B70, 2, gl.DepthRangeArrayv,
             (0.0, 1.0) * count)):
        readers = [_indexed(getter, kind, enum, index, size) for index in range(count)]
        array = (kind * (size * count))()
        yield Item(name, _both(*readers), _write_array(setter, count, array), baseline)
    yield _grouped_flag(gl, "scissor_test", 0x0C11, count)


def _write_array(setter, count, array):
    def write(values):
        array[:] = values
        setter(0, count, array)

    return write


def _raster_items(gl):
    yield Item("depth_func", _integers(gl, 0x0B74), _call(gl.DepthFunc), (_LESS,))
    yield Item("depth_mask", _integers(gl, 0x0B72), _call(gl.DepthMask), (1,))
    yield Item("cull_mode", _integers(gl, 0x0B45), _call(gl.CullFace), (_BACK,))
    yield Item("front_face", _integers(gl, 0x0B46), _call(gl.FrontFace), (_CCW,))
    yield Item("polygon_mode", _integers(gl, 0x0B40), _call(gl.PolygonMode, _FRONT_AND_BACK), (_FILL,))
    if gl.has("PolygonOffsetClamp"):
        yield Item("polygon_offset", _both(*(_floats(gl, enum) for enum in (0x8038, 0x2A00, 0x8E1B))),
                   _call(gl.PolygonOffsetClamp), None)
    else:
        yield Item("polygon_offset", _both(_floats(gl, 0x8038), _floats(gl, 0x2A00)),
                   _call(gl.PolygonOffset), None)
    yield Item("primitive_restart_index", _integers(gl, 0x8F9E),
               _write_unsigned(gl.PrimitiveRestartIndex), None)
    yield Item("logic_op", _integers(gl, 0x0BF0), _call(gl.LogicOp), None)
    yield Item("sample_coverage_value", _both(_floats(gl, 0x80AA), _integers(gl, 0x80AB)),
               _call(gl.SampleCoverage), None)
    yield Item("sample_mask_value", _indexed(gl.GetIntegeri_v, ctypes.c_int, 0x8E52, 0),
               _write_unsigned(gl.SampleMaski, 0), None)
    yield Item("provoking_vertex", _integers(gl, 0x8E4F), _call(gl.ProvokingVertex), (_LAST_VERTEX,))
    yield Item("line_width", _floats(gl, 0x0B21), _call(gl.LineWidth), None)
    yield Item("point_size", _floats(gl, 0x0B11), _call(gl.PointSize), None)
    yield Item("clear_color", _floats(gl, 0x0C22, 4), _call(gl.ClearColor), None)
    yield Item("clear_depth", _reader(gl.GetDoublev, ctypes.c_double, 0x0B73, 1), _call(gl.ClearDepth), None)
    yield Item("clear_stencil", _integers(gl, 0x0B91), _call(gl.ClearStencil), None)
    # a host's GL_TRUE would clamp our float readbacks to 0..1
    yield Item("clamp_read_color", _integers(gl, 0x891C), _call(gl.ClampColor, 0x891C), (0x891D,))
    if gl.has("ClipControl"):
        yield Item("clip_control", _both(_integers(gl, 0x935C), _integers(gl, 0x935D)), _call(gl.ClipControl),
                   (0x8CA1, 0x935E))  # LOWER_LEFT, NEGATIVE_ONE_TO_ONE


def _write_unsigned(function, *first):
    return lambda values: function(*first, *(value & _ALL_BITS for value in values))


def _unless_equal(read, write):
    return lambda values: None if read() == values else write(values)


def _stencil_items(gl):
    """Both faces; written back only when changed: references read as 0 while no stencil buffer is bound."""
    front = {"Func": (0x0B92, 0x0B97, 0x0B93), "Op": (0x0B94, 0x0B95, 0x0B96), "Mask": (0x0B98,)}
    back = {"Func": (0x8800, 0x8CA3, 0x8CA4), "Op": (0x8801, 0x8802, 0x8803), "Mask": (0x8CA5,)}
    for side, face, queries in (("front", _FRONT, front), ("back", _BACK, back)):
        for name, enums in queries.items():
            read = _both(*(_integers(gl, enum) for enum in enums))
            write = _write_unsigned(getattr(gl, f"Stencil{name}Separate"), face)
            yield Item(f"stencil_{name.lower()}_{side}", read, _unless_equal(read, write), None)


def _pixel_store_items(gl):
    for enum in _PIXEL_STORE:
        yield Item(f"pixel_store_{enum:#06x}", _integers(gl, enum), _call(gl.PixelStorei, enum),
                   (4,) if enum in (0x0CF5, 0x0D05) else (0,))


def _texture_items(gl, ctx):
    """Textures and samplers of the guarded units; reading and writing leave the active unit as it was."""
    active, bind_texture, bind_sampler, get = gl.ActiveTexture, gl.BindTexture, gl.BindSampler, gl.GetIntegerv
    buffer, current = (ctypes.c_int * 16)(), _integers(gl, _ACTIVE_TEXTURE)
    units = [*range(min(GUARDED_UNITS, ctx.max_texture_units))]
    units += [ctx.default_texture_unit] if ctx.default_texture_unit not in units else []
    queries = (*_TEXTURES.values(), _SAMPLER_BINDING)

    def read():
        values, before = [], current()[0]
        for unit in units:
            active(_TEXTURE0 + unit)
            for query in queries:
                get(query, buffer)
                values.append(buffer[0])
        active(before)
        return tuple(values)

    def write(values):
        before, values = current()[0], iter(values)
        for unit in units:
            active(_TEXTURE0 + unit)
            for target in _TEXTURES:
                bind_texture(target, next(values))
            bind_sampler(unit, next(values))
        active(before)

    def unbind_samplers(_):
        for unit in units:
            bind_sampler(unit, 0)

    yield Item("active_texture", current, _call(active), None)
    yield Item("texture_units", read, write, None)
    # read and restored with the textures above; this entry only starts our passes without samplers
    yield Item("samplers", tuple, lambda values: unbind_samplers(values) if values else None, (0,))


def state_items(ctx):
    """The table of guarded state of `ctx`, made once per context, in the order of restoring."""
    store = context_store(ctx)
    if "state_items" not in store:
        gl = gl_functions(ctx)
        store["state_items"] = (
            *_binding_items(gl), *_framebuffer_items(gl), *_viewport_items(gl), *_output_items(gl), *_flag_items(gl),
            *_raster_items(gl), *_stencil_items(gl), *_pixel_store_items(gl), *_texture_items(gl, ctx),
        )
    return store["state_items"]


@contextmanager
def preserve_state(ctx):
    """Record the host's OpenGL state, set a known baseline, and restore all of it on leaving, error or not.

    Inside, everything is off and at its default: no depth test (func LESS, mask on), blend, cull, stencil,
    scissor, sRGB, discard; colour masks on; default clip control; no sampler objects; framebuffer 0 bound.
    moderngl's memory of its own state (bound framebuffer, enable flags, depth func and the like) is put back
    too.

    Parameters
    ----------
    ctx : moderngl.Context
        The host's live, current context.

    Yields
    ------
    HostState
        The framebuffer and viewport the host had bound.
    """
    check_alive(ctx)
    items = state_items(ctx)
    values = [item.read() for item in items]
    tracked = [(name, getattr(ctx.mglo, name)) for name in _TRACKED]
    framebuffer, native_framebuffer = ctx.fbo, ctx.mglo.fbo
    found = HostState(gl_functions(ctx).integer(_DRAW_BINDING), gl_functions(ctx).integers(0x0BA2, 4))
    window = ctx.detect_framebuffer(0)
    ctx.fbo, ctx.mglo.fbo = window, window.mglo  # so that the scope below remembers none of the host's
    scope = ctx.scope(window, enable_only=ctx.NOTHING)  # keeps moderngl's enable flags, which have no getter
    try:
        with scope:
            for item, value in zip(items, values, strict=True):
                if item.baseline is not None and item.baseline != value:
                    item.write(item.baseline)
            yield found
    finally:
        for name, value in tracked:
            setattr(ctx.mglo, name, value)
        ctx.fbo, ctx.mglo.fbo = framebuffer, native_framebuffer
        for item, value in zip(items, values, strict=True):
            item.write(value)
        scope.release()
