"""Compile, cache and draw with GLSL programs; driver messages are given back in terms of our files.

The whole loader can be imported from here; `source` composes the text and `uniforms` feeds the linked
program.
"""

import os
import re

import moderngl

from shadowatmo.errors import ShaderError
from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.gl.source import (
    LINE_STRIDE,
    SHADER_DIR_VARIABLE,
    Composer,
    ShaderSource,
    check_mentioned,
    compose_source,
)
from shadowatmo.passes.gl.uniforms import bind_textures, prepare_program, sampler_units, set_uniforms

__all__ = ["Fullscreen", "ShaderSource", "bind_textures", "build_program", "compose_source",
           "release_programs", "sampler_units", "set_uniforms", "translate_log"]

# source and line of a driver message: Mesa `0:12(3): error: text`; Apple, AMD and Intel `ERROR: 0:12: text`;
# NVIDIA `0(12) : error C0000: text`
_MESSAGES = (
    re.compile(r"^(?P<source>\d+):(?P<line>\d+)\(\d+\):\s*(?P<text>.*)$"),
    re.compile(r"^(?P<kind>ERROR|WARNING):\s*(?P<source>\d+):(?P<line>\d+):\s*(?P<text>.*)$"),
    re.compile(r"^(?P<source>\d+)\((?P<line>\d+)\)\s*:\s*(?P<text>.*)$"),
)
_STAGE = re.compile(r"^(vertex|geometry|fragment)(_shader$| info)", re.IGNORECASE)


def translate_log(log, stages):
    """Driver messages with ``file.glsl:line`` in place of source-string numbers.

    Parameters
    ----------
    log : str
        What the driver, or moderngl on its behalf, said.
    stages : dict of str to tuple of str
        File names by source-string number, for ``"vertex"``, ``"geometry"``, ``"fragment"``. The headings of
        the log choose the stage; before the first heading it is the last of `stages`.

    Returns
    -------
    list of str
        One entry per line of the log that says something; a line without a place is kept as it is.
    """
    names = list(stages.values())[-1]
    messages = []
    for line in (line.strip() for line in log.splitlines()):
        heading = _STAGE.match(line)
        if heading:
            names = stages.get(heading.group(1).lower(), names)
            continue
        if not line or set(line) <= {"=", "-"} or line == "Program":
            continue
        for pattern in _MESSAGES:
            match = pattern.match(line)
            if match:
                break
        else:
            messages.append(line)
            continue
        source, number = int(match["source"]), int(match["line"])
        if number >= LINE_STRIDE:
            source, number = divmod(number, LINE_STRIDE)
        file = names[source] if source < len(names) else f"source {source}"
        kind = f"{match['kind'].lower()}: " if "kind" in match.groupdict() else ""
        messages.append(f"{file}:{number}: {kind}{match['text']}")
    return messages


def build_program(ctx, fragment, vertex="fullscreen.vert", geometry=None, defines=None, optional=()):
    """Compile and link a program, or take it from the context's cache.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.
    fragment, vertex, geometry : str
        Entry files; `geometry` may be None.
    defines : dict, optional
        As in `compose_source`, for all stages; each name must be mentioned by one stage at least.
    optional : iterable of str
        Defines that no stage needs to mention.

    Returns
    -------
    moderngl.Program
        Every sampler uniform has a texture unit of its own, see `sampler_units`. Owned by the cache:
        `release_programs` frees it.

    Raises
    ------
    ShaderError
        Composition failed, or the driver refused: one ``file:line: text`` per message, and the defines.
    """
    defines = dict(defines or {})
    cache = context_store(ctx).setdefault("programs", {})
    key = (fragment, vertex, geometry, tuple(sorted((name, str(value)) for name, value in defines.items())),
           os.environ.get(SHADER_DIR_VARIABLE))
    if key in cache:
        return cache[key]
    names = {"vertex": vertex, "geometry": geometry, "fragment": fragment}
    names = {stage: name for stage, name in names.items() if name is not None}
    composers = {stage: Composer(defines) for stage in names}
    sources = {stage: composers[stage].compose(name) for stage, name in names.items()}
    check_mentioned(defines, set().union(*(c.words for c in composers.values())), optional, names.values())
    try:
        program = ctx.program(**{f"{stage}_shader": source.text for stage, source in sources.items()})
    except moderngl.Error as error:
        messages = translate_log(str(error), {stage: source.files for stage, source in sources.items()})
        in_force = ", ".join(f"{name}={value}" for name, value in sorted(defines.items())) or "none"
        title = f"{' + '.join(names.values())} with defines: {in_force}"
        raise ShaderError("\n  ".join([title, *messages])) from None
    declared = frozenset().union(*(source.uniforms for source in sources.values()))
    prepare_program(ctx, program, " + ".join(names.values()), declared)
    cache[key] = program
    return program


def release_programs(ctx):
    """Release every program that `build_program` made for `ctx`; later calls build afresh (hot reload)."""
    for program in context_store(ctx).pop("programs", {}).values():
        program.release()


class Fullscreen:
    """Draws one triangle over the whole viewport with a program whose vertex stage is ``fullscreen.vert``.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.
    program : moderngl.Program
        From `build_program`.
    """

    def __init__(self, ctx, program):
        self.program = program
        self._vertex_array = ctx.vertex_array(program, [])

    def draw(self, instances=1):
        """Draw into the bound framebuffer and its viewport."""
        self._vertex_array.render(moderngl.TRIANGLES, vertices=3, instances=instances)

    def release(self):
        """Release the vertex array; the program stays with the cache."""
        self._vertex_array.release()
