"""Compose GLSL sources: defines, includes, features and line numbers.

An entry shader begins with ``#version 330 core``. The loader inserts its defines below that line, resolves
``#include "file.glsl"`` (each file at most once, so cycles and include guards are no concern), and decides
every ``#ifdef HAS_X`` / ``#ifndef HAS_X`` itself: the driver never sees the text of an unused feature.

Line numbers: ``#line`` carries the number of the source string *and* folds it into the line,
``#line S * 100000 + N S``. Mesa 22.3 reports source 0 for every semantic error whatever ``#line`` said (only
syntax errors keep the source), so the line alone must tell the file.
"""

import os
import re
from dataclasses import dataclass, field
from importlib.resources import files
from numbers import Integral, Real
from pathlib import Path

import numpy as np

from shadowatmo.errors import ShaderError

VERSION_LINE = "#version 330 core"
LINE_STRIDE = 100_000  # lines per source string in the folded line numbers
SHADER_DIR_VARIABLE = "SHADOWATMO_SHADER_DIR"

_DIRECTIVE = re.compile(r"^\s*#\s*(\w+)\b\s*(.*)$")
_INCLUDE = re.compile(r'^"([^"/\\]+)"\s*$')
_FEATURE = re.compile(r"^(HAS_\w+)\s*$")
_FEATURE_WORD = re.compile(r"\bHAS_\w+")
_DEFINE_NAME = re.compile(r"^[A-Za-z](?!.*__)\w*$")
_UNIFORM = re.compile(r"(?<!\w)uniform\s+((?:lowp|mediump|highp)\s+)?\w+\s+([^;{}]+);")


@dataclass(frozen=True)
class ShaderSource:
    """A composed shader.

    Parameters
    ----------
    text : str
        What the driver gets; comments are taken out.
    files : tuple of str
        File names in the order of their source-string numbers; the entry file is number 0.
    defines : dict
        The defines in force, HAS_ names included.
    uniforms : frozenset of str
        Names of the uniforms that `text` declares.
    """

    text: str
    files: tuple
    defines: dict = field(hash=False)
    uniforms: frozenset


def read_shader(name):
    """Text of the shader file `name`, from SHADOWATMO_SHADER_DIR where that is set, else from the package."""
    folder = os.environ.get(SHADER_DIR_VARIABLE)
    path = Path(folder) / name if folder else files("shadowatmo.shaders").joinpath(name)
    try:
        return path.read_text("utf-8")
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        where = f"{folder} ({SHADER_DIR_VARIABLE})" if folder else "package shadowatmo.shaders"
        raise ShaderError(f"there is no shader {name!r} in {where}") from None


def compose_source(name, defines=None, optional=()):
    """Compose one shader from its entry file.

    Parameters
    ----------
    name : str
        Entry file, such as ``"atmosphere.frag"``.
    defines : dict of str to int, float, str or True, optional
        Inserted below the version line, sorted by name. A name that begins with HAS_ selects a feature
        instead: it counts as present when its value is true, and never reaches the driver.
    optional : iterable of str
        Defines that no file needs to mention.

    Returns
    -------
    ShaderSource

    Raises
    ------
    ShaderError
        A missing include, unbalanced conditionals, a wrong first line, a define that no file mentions.
    """
    composer = Composer(defines or {})
    source = composer.compose(name)
    check_mentioned(defines or {}, composer.words, optional, (name,))
    return source


def check_mentioned(defines, words, optional, names):
    unknown = sorted(set(defines) - words - set(optional))
    if unknown:
        raise ShaderError(f"no file of {' + '.join(names)} mentions the define(s) {', '.join(unknown)}")


class Composer:
    """Walks an entry file and its includes; `words` collects every identifier of the raw texts."""

    def __init__(self, defines):
        self.defines = dict(defines)
        self.features = {name for name, value in defines.items() if name.startswith("HAS_") and value}
        self.files = []
        self.words = set()

    def compose(self, name):
        text = "\n".join(self._file(name)) + "\n"
        return ShaderSource(text, tuple(self.files), self.defines, frozenset(_declared_uniforms(text)))

    def _file(self, name):
        source = len(self.files)
        raw = read_shader(name)
        self.files.append(name)
        self.words.update(re.findall(r"\w+", raw))
        lines = raw.splitlines()
        if source:
            yield _line_directive(source, 1)
        else:
            if not lines or lines[0].strip() != VERSION_LINE:
                raise ShaderError(f"{name}:1: an entry shader must begin with {VERSION_LINE!r}")
            yield VERSION_LINE
            yield from (_define_line(key, value) for key, value in sorted(self.defines.items())
                        if not key.startswith("HAS_"))
            yield _line_directive(0, 2)
        yield from self._body(name, source, lines)

    def _body(self, name, source, lines):
        """Lines of one file with features decided and includes expanded; a dead line becomes an empty one."""
        open_blocks = []  # (is_feature, live before, live now, line number, else seen) per conditional
        in_comment = False
        for number, line in enumerate(lines, 1):
            if number == 1 and source == 0:
                continue
            where = f"{name}:{number}"
            # comments must go: moderngl looks for #include in them too
            code, in_comment = _strip_comments(line, in_comment)
            match = _DIRECTIVE.match(code)
            live = open_blocks[-1][2] if open_blocks else True
            if match is None:
                yield code if live else ""
                continue
            word, rest = match.group(1), match.group(2).strip()
            if word == "include":
                yield from self._include(where, source, number, rest, open_blocks) if live else ("",)
            elif word in ("if", "ifdef", "ifndef", "elif", "else", "endif"):
                passes_through = self._conditional(where, number, word, rest, open_blocks)
                yield code if live and passes_through else ""
            elif word == "version":
                raise ShaderError(f"{where}: {VERSION_LINE!r} belongs on line 1 of an entry shader, "
                                  "and entry shaders are never included")
            elif _FEATURE_WORD.search(rest):
                raise ShaderError(f"{where}: HAS_ names may stand in #ifdef and #ifndef only")
            else:
                yield code if live else ""
        if open_blocks:
            raise ShaderError(f"{name}:{open_blocks[-1][3]}: this conditional has no #endif")

    def _conditional(self, where, number, word, rest, blocks):
        """Push, flip or pop a conditional; True when it is ordinary GLSL and goes to the driver."""
        if word in ("if", "ifdef", "ifndef"):
            feature = _FEATURE.match(rest) if word != "if" else None
            if feature is None and _FEATURE_WORD.search(rest):
                raise ShaderError(f"{where}: HAS_ names may stand alone in #ifdef and #ifndef only")
            before = blocks[-1][2] if blocks else True
            chosen = feature is None or (feature.group(1) in self.features) == (word == "ifdef")
            blocks.append((feature is not None, before, before and chosen, number, False))
            return feature is None
        if not blocks:
            raise ShaderError(f"{where}: #{word} without an open conditional")
        is_feature, before, live, opened, else_seen = blocks[-1]
        if word == "endif":
            blocks.pop()
        elif else_seen:
            raise ShaderError(f"{where}: #{word} after the #else of the conditional of line {opened}")
        elif word == "else":
            blocks[-1] = (is_feature, before, before and not live if is_feature else live, opened, True)
        elif is_feature or _FEATURE_WORD.search(rest):
            raise ShaderError(f"{where}: #elif cannot select a HAS_ feature; nest #ifdef instead")
        return not is_feature

    def _include(self, where, source, number, rest, blocks):
        match = _INCLUDE.match(rest)
        if match is None:
            raise ShaderError(f'{where}: expected #include "file.glsl", got #include {rest}')
        if not all(is_feature for is_feature, *_ in blocks):
            # each file is included once: hidden from the driver here, it would be missing further down
            raise ShaderError(f"{where}: #include inside an ordinary conditional; use #ifdef HAS_... instead")
        target = match.group(1)
        if target in self.files:
            yield ""
            return
        try:
            read_shader(target)
        except ShaderError as error:
            raise ShaderError(f"{where}: {error}") from None
        yield from self._file(target)
        yield _line_directive(source, number + 1)


def _line_directive(source, line):
    return f"#line {source * LINE_STRIDE + line} {source}"


def _strip_comments(line, in_comment):
    """The code of one line without its comments, and whether a block comment is still open after it."""
    code, position = [], 0
    while position < len(line):
        if in_comment:
            end = line.find("*/", position)
            if end < 0:
                return "".join(code), True
            in_comment, position = False, end + 2
        elif line.startswith("//", position):
            break
        elif line.startswith("/*", position):
            code.append(" ")
            in_comment, position = True, position + 2
        else:
            code.append(line[position])
            position += 1
    return "".join(code).rstrip(), in_comment


def _define_line(name, value):
    if not _DEFINE_NAME.match(name) or name.startswith(("GL_", "gl_")):
        raise ShaderError(f"{name!r} cannot be the name of a define")
    if value is True or isinstance(value, np.bool_) and value:
        text = "1"
    elif isinstance(value, Integral) and not isinstance(value, bool) and -(2**31) <= value < 2**31:
        text = str(int(value))
    elif isinstance(value, Real) and not isinstance(value, Integral) and abs(value) < 3.4e38:
        text = repr(float(value))
    elif isinstance(value, str) and "\n" not in value:
        return f"#define {name} {value}"
    else:
        raise ShaderError(f"define {name} = {value!r}; expected True, a 32-bit int, a float or one line")
    return f"#define {name} ({text})" if text.startswith("-") else f"#define {name} {text}"


def _declared_uniforms(text):
    for match in _UNIFORM.finditer(text):
        for declarator in re.sub(r"\[[^\]]*\]", "", match.group(2)).split(","):
            yield declarator.split("=")[0].strip()
