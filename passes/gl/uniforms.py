"""Feed a program: uniforms from NumPy, textures to units of their own.

What we know of a program beyond what moderngl keeps hangs on `Program.extra`, put there once after linking.
"""

import re
from dataclasses import dataclass

import moderngl
import numpy as np

from shadowatmo.errors import ShaderError
from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.gl.functions import gl_functions

_SAMPLER_TYPES = frozenset((*range(0x8B5D, 0x8B65), *range(0x8DC0, 0x8DC6), *range(0x8DC9, 0x8DD9),
                            *range(0x900C, 0x9010), *range(0x9108, 0x910E)))
# gl_type -> (columns, rows); in NumPy the matrix has the shape (rows, columns)
_MATRICES = {0x8B5A: (2, 2), 0x8B65: (2, 3), 0x8B66: (2, 4), 0x8B67: (3, 2), 0x8B5B: (3, 3), 0x8B68: (3, 4),
             0x8B69: (4, 2), 0x8B6A: (4, 3), 0x8B5C: (4, 4)}
_UNSIGNED = frozenset((0x1405, 0x8DC6, 0x8DC7, 0x8DC8))
_INTEGERS = frozenset((0x1404, 0x8B53, 0x8B54, 0x8B55, 0x8B56, 0x8B57, 0x8B58, 0x8B59)) | _UNSIGNED


@dataclass
class _ProgramInfo:
    """Label for messages, declared uniforms, first unit by sampler, writer by other uniform."""

    label: str
    declared: frozenset
    units: dict
    writers: dict


def prepare_program(ctx, program, label, declared):
    """Give every sampler its unit and every other uniform its writer."""
    units, writers, next_unit = {}, {}, 0
    for name in sorted(program):
        member = program[name]
        if not isinstance(member, moderngl.Uniform):
            continue
        if member.gl_type in _SAMPLER_TYPES:
            count = member.array_length
            if next_unit + count > ctx.max_texture_units:
                raise ShaderError(f"{label}: more than {ctx.max_texture_units} samplers in use")
            # two samplers of different kinds on one unit make the draw fail without a word, so none may share
            member.value = next_unit if count == 1 else list(range(next_unit, next_unit + count))
            units[name] = next_unit
            next_unit += count
        else:
            writers[name] = _make_writer(label, name, member)
    program.extra = _ProgramInfo(label, declared, units, writers)


def _make_writer(label, name, uniform):
    """A function of one value that checks its shape and writes its bytes."""
    matrix = _MATRICES.get(uniform.gl_type)
    shape = matrix[::-1] if matrix else (uniform.dimension,) if uniform.dimension > 1 else ()
    length, ndim = uniform.array_length, len(shape)
    dtype = np.float32
    if uniform.gl_type in _INTEGERS:
        dtype = np.uint32 if uniform.gl_type in _UNSIGNED else np.int32
    expected = f"({length}+, {', '.join(map(str, shape))})" if length > 1 else str(shape)

    def write(value):
        array = np.asarray(value)
        if dtype is not np.float32 and array.dtype.kind == "f":
            raise ShaderError(f"{label}: uniform {name} is an integer; got {value!r}")
        got = array.shape
        if length > 1:
            # the driver may have cut the array behind the last element in use
            array = array[:length] if array.ndim == ndim + 1 and array.shape[0] >= length else None
        elif array.ndim == ndim + 1 and array.shape[0] >= 1:
            array = array[0]
        if array is None or array.shape[array.ndim - ndim:] != shape or array.ndim != ndim + (length > 1):
            raise ShaderError(f"{label}: uniform {name} expects shape {expected}, got {got}")
        if matrix:
            array = array.swapaxes(-1, -2)  # GLSL wants columns, NumPy has rows
        uniform.write(array.astype(dtype).tobytes())

    return write


def _info(program):
    info = program.extra
    if not isinstance(info, _ProgramInfo):
        raise ShaderError("this program was not made by build_program")
    return info


def sampler_units(program):
    """Texture unit of each sampler uniform the program kept: dict of name to first unit."""
    return dict(_info(program).units)


def set_uniforms(program, values):
    """Set uniforms by name.

    Parameters
    ----------
    program : moderngl.Program
        From `build_program`.
    values : mapping of str to number, sequence or ndarray
        Scalars, vectors (n,), matrices as NumPy has them (rows, columns), so that GLSL ``M * v`` is ``M @
        v``, and arrays of each with one more leading axis. float64 is rounded to float32. A name that the
        text declares and the driver optimized out is ignored.

    Raises
    ------
    ShaderError
        A name that no stage declares, a sampler, or a value of the wrong shape.
    """
    info = _info(program)
    with np.errstate(all="ignore"):  # values outside float32 become inf or 0; the public types validate
        for name, value in values.items():
            writer = info.writers.get(name)
            if writer is not None:
                writer(value)
            elif name in info.units:
                raise ShaderError(f"{info.label}: {name} is a sampler; use bind_textures")
            else:
                _check_declared(info, name)


def _check_declared(info, name):
    if re.split(r"[.\[]", name, maxsplit=1)[0] not in info.declared:
        names = ", ".join(sorted(info.declared))
        raise ShaderError(f"{info.label} declares no uniform {name!r}; it has {names}")


def bind_textures(program, textures):
    """Bind each texture to the unit of its sampler uniform.

    Parameters
    ----------
    program : moderngl.Program
        From `build_program`.
    textures : mapping of str to texture or sequence of textures
        moderngl textures by sampler name. A depth texture, also a host's, is read through a sampler object of
        our own (no comparison, nearest): its own parameters may ask for comparison, and stay the host's.

    Raises
    ------
    ShaderError
        A name that no stage declares, or a sequence of the wrong length.
    """
    info = _info(program)
    for name, texture in textures.items():
        unit = info.units.get(name)
        if unit is None:
            _check_declared(info, name)
            continue
        sequence = texture if isinstance(texture, (list, tuple)) else (texture,)
        count = program[name].array_length
        if len(sequence) != count:
            raise ShaderError(f"{info.label}: {name} takes {count} textures, got {len(sequence)}")
        for offset, item in enumerate(sequence):
            _bind(program.ctx, item, unit + offset)


def _bind(ctx, texture, unit):
    texture.use(unit)
    if isinstance(texture, moderngl.Texture) and gl_functions(ctx).bound_texture_has_depth():
        store = context_store(ctx)
        if "depth_sampler" not in store:
            store["depth_sampler"] = ctx.sampler(repeat_x=False, repeat_y=False, compare_func="",
                                                 filter=(moderngl.NEAREST, moderngl.NEAREST))
        store["depth_sampler"].use(unit)
    else:
        ctx.clear_samplers(unit, unit + 1)  # one left by another draw would override the texture's own filter
