"""The shader loader: composition, features, line numbers, driver messages, uniforms and texture units."""

import numpy as np
import pytest

from shadowatmo.errors import ShaderError
from shadowatmo.passes.gl.shader import (
    Fullscreen,
    build_program,
    compose_source,
    release_programs,
    translate_log,
)
from shadowatmo.passes.gl.source import LINE_STRIDE, read_shader
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import Target

VERSION = "#version 330 core\n"


def lines(source):
    """Composed lines that say something."""
    return [line for line in source.text.splitlines() if line.strip()]


def test_defines_come_first_and_sorted(folder):
    folder(a_frag=VERSION + "float x = B + A + C; // D E HAS_F\n")
    source = compose_source("a.frag", {"C": -2, "B": 1e-5, "A": 3, "D": True, "E": "vec3(1.0)", "HAS_F": 1})
    assert lines(source) == [
        "#version 330 core",
        "#define A 3",
        "#define B 1e-05",
        "#define C (-2)",
        "#define D 1",
        "#define E vec3(1.0)",
        "#line 2 0",
        "float x = B + A + C;",
    ]
    assert source.files == ("a.frag",)
    assert source.defines["HAS_F"] == 1


@pytest.mark.parametrize("value", [None, False, float("nan"), float("inf"), 2**31, "two\nlines", [1]])
def test_bad_define_values(folder, value):
    folder(a_frag=VERSION + "float x = A;\n")
    with pytest.raises(ShaderError, match="define A"):
        compose_source("a.frag", {"A": value})


@pytest.mark.parametrize("name", ["1A", "A B", "gl_A", "GL_A", "A__B"])
def test_bad_define_names(folder, name):
    folder(a_frag=VERSION)
    with pytest.raises(ShaderError, match="cannot be the name"):
        compose_source("a.frag", {name: 1}, optional=[name])


@pytest.mark.parametrize("name", ["NODE_COUMT", "HAS_OCCLUDER"])
def test_a_define_nobody_mentions_is_a_typo(folder, name):
    folder(a_frag=VERSION + "float x = NODE_COUNT;\n#ifdef HAS_OCCLUDERS\n#endif\n")
    with pytest.raises(ShaderError, match=name):
        compose_source("a.frag", {"NODE_COUNT": 3, name: 1})
    compose_source("a.frag", {"NODE_COUNT": 3, name: 1}, optional=[name])


def test_each_file_is_included_once_cycles_too(folder):
    folder(
        a_frag=VERSION + '#include "b.glsl"\n#include "c.glsl"\n#include "b.glsl"\nmain\n',
        b_glsl='#include "c.glsl"\n#include "b.glsl"\nbody_b\n',
        c_glsl='#include "b.glsl"\nbody_c\n',
    )
    source = compose_source("a.frag")
    assert source.files == ("a.frag", "b.glsl", "c.glsl")
    body = [line for line in lines(source) if not line.startswith("#")]
    assert body == ["body_c", "body_b", "main"]


def test_every_line_can_be_found_again(folder):
    """Follow the #line directives as a compiler does: each marker must land on its own file and line."""
    folder(
        a_frag=VERSION
        + "a.frag:2\n"
        + '#include "b.glsl"\n'
        + "a.frag:4\n#ifdef HAS_X\nx\n#endif\na.frag:8\n",
        b_glsl='b.glsl:1\n#include "c.glsl"\n\nb.glsl:4\n',
        c_glsl="/* two\nlines */ c.glsl:2\n",
    )
    source = compose_source("a.frag", {"HAS_X": False})
    number, found = 0, 0
    for line in source.text.splitlines():
        number += 1
        if line.startswith("#line"):
            _, folded, string = line.split()
            assert int(folded) // LINE_STRIDE == int(string)
            number = int(folded) - 1
        elif ":" in line:
            file, expected = line.split(":")
            assert (source.files[number // LINE_STRIDE], number % LINE_STRIDE) == (
                file.strip(),
                int(expected),
            )
            found += 1
    assert found == 6


FEATURES = (
    VERSION
    + """
#ifdef HAS_A
only_a
#ifndef HAS_B
a_without_b
#else
#include "b.glsl"
#endif // HAS_B
#else
#if N > 1
without_a
#elif N > 0
#else
#endif
#ifdef ORDINARY
#endif
#endif
"""
)


@pytest.mark.parametrize(
    ("defines", "expected"),
    [
        ({}, ["#if N > 1", "without_a", "#elif N > 0", "#else", "#endif", "#ifdef ORDINARY", "#endif"]),
        (
            {"HAS_A": False, "HAS_B": True},
            ["#if N > 1", "without_a", "#elif N > 0", "#else", "#endif", "#ifdef ORDINARY", "#endif"],
        ),
        ({"HAS_A": True}, ["only_a", "a_without_b"]),
        ({"HAS_A": True, "HAS_B": 1}, ["only_a", "body_b"]),
    ],
)
def test_features_are_decided_by_the_loader(folder, defines, expected):
    folder(a_frag=FEATURES)
    if "body_b" in expected:
        folder(b_glsl="body_b\n")  # missing otherwise: a dead branch must not be read
    composed = lines(compose_source("a.frag", defines))
    assert [line for line in composed[1:] if not line.startswith("#line")] == expected


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ("#ifdef HAS_A\n", "a.frag:2", "no #endif"),
        ("\n#if X\n", "a.frag:3", "no #endif"),
        ("#endif\n", "a.frag:2", "without an open"),
        ("#else\n", "a.frag:2", "without an open"),
        ("#ifdef HAS_A\n#else\n#else\n#endif\n", "a.frag:4", "after the #else"),
        ("#ifdef HAS_A\n#elif X\n#endif\n", "a.frag:3", "#elif"),
        ("#if defined(HAS_A)\n#endif\n", "a.frag:2", "stand alone"),
        ("#if X\n#elif defined(HAS_A)\n#endif\n", "a.frag:3", "#elif"),
        ("#define HAS_A\n", "a.frag:2", "#ifdef and #ifndef only"),
        ('#include "none.glsl"\n', "a.frag:2", "none.glsl"),
        ('\n#include "deep.glsl"\n', "deep.glsl:3", "none.glsl"),
        ("#include <b.glsl>\n", "a.frag:2", "expected #include"),
        ('#include "../b.glsl"\n', "a.frag:2", "expected #include"),
        ('#if X\n#include "b.glsl"\n#endif\n', "a.frag:3", "ordinary conditional"),
        ('#include "entry.frag"\n', "entry.frag:1", "never included"),
        ('#include "open.glsl"\n#endif\n', "open.glsl:1", "no #endif"),
    ],
)
def test_mistakes_name_file_and_line(folder, text, place, what):
    folder(
        a_frag=VERSION + text,
        b_glsl="",
        entry_frag=VERSION,
        open_glsl="#ifdef HAS_A\n",
        deep_glsl='\n\n#include "none.glsl"\n',
    )
    with pytest.raises(ShaderError, match=what) as info:
        compose_source("a.frag")
    assert str(info.value).startswith(f"{place}: ")


@pytest.mark.parametrize("text", ["", "\n" + VERSION, "#version 450 core\n"])
def test_the_version_line_is_demanded(folder, text):
    folder(a_frag=text)
    with pytest.raises(ShaderError, match="a.frag:1: .*#version 330 core"):
        compose_source("a.frag")


def test_comments_do_not_count(folder):
    folder(
        a_frag=VERSION + '// #include "none.glsl"\n'
        '/* #ifdef HAS_A\n#include "none.glsl" */ code /* x */ + 1\n'
    )
    assert lines(compose_source("a.frag"))[-1].split() == ["code", "+", "1"]


def test_missing_entry_file_and_folder(folder, monkeypatch):
    with pytest.raises(ShaderError, match="'none.frag'.*SHADOWATMO_SHADER_DIR"):
        compose_source("none.frag")
    monkeypatch.delenv("SHADOWATMO_SHADER_DIR")
    with pytest.raises(ShaderError, match="'none.frag' in package shadowatmo.shaders"):
        compose_source("none.frag")


@pytest.mark.parametrize(
    ("log", "expected"),
    [
        ("0:12(3): error: no such thing", "a.frag:12: error: no such thing"),  # Mesa
        (
            f"0:{LINE_STRIDE + 7}(3): error: x",
            "b.glsl:7: error: x",
        ),  # Mesa forgets the source, the line keeps it
        (f"1:{LINE_STRIDE + 7}(3): preprocessor error: x", "b.glsl:7: preprocessor error: x"),
        (
            '0(12) : error C1008: undefined variable "x"',
            'a.frag:12: error C1008: undefined variable "x"',
        ),  # NVIDIA
        (f"1({LINE_STRIDE + 2}) : warning C7050: x", "b.glsl:2: warning C7050: x"),
        ("ERROR: 0:12: 'x' : undeclared", "a.frag:12: error: 'x' : undeclared"),  # Apple, AMD, Intel
        (f"WARNING: 1:{LINE_STRIDE + 3}: x", "b.glsl:3: warning: x"),
        ("ERROR: 9:1: x", "source 9:1: error: x"),
        (
            "error: unresolved reference to function `f'",
            "error: unresolved reference to function `f'",
        ),  # linker
    ],
)
def test_driver_messages_of_every_kind(log, expected):
    assert translate_log(log, {"fragment": ("a.frag", "b.glsl")}) == [expected]


def test_headings_choose_the_stage():
    log = (
        "GLSL Compiler failed\n\nvertex_shader\n=====\n0:3(1): error: x\n\n"
        "fragment_shader\n====\n0:4(1): error: y\n"
    )
    assert translate_log(log, {"vertex": ("v.vert",), "fragment": ("f.frag",)}) == [
        "GLSL Compiler failed",
        "v.vert:3: error: x",
        "f.frag:4: error: y",
    ]


@pytest.mark.parametrize(
    "mistake",
    ["float f() { return vec2(1.0); }", "float f() { return 1.0 1.0; }", "float f() { return nowhere; }"],
)
def test_a_compile_error_names_the_included_file(ctx, folder, mistake):
    folder(
        a_frag=VERSION + '#include "b.glsl"\nout vec4 color;\nvoid main() { color = vec4(f() * N); }\n',
        b_glsl=f"// first\n\n{mistake}\n",
    )
    with pytest.raises(ShaderError) as info:
        build_program(ctx, "a.frag", defines={"N": 3})
    assert "\n  b.glsl:3: " in str(info.value)
    assert str(info.value).startswith("fullscreen.vert + a.frag with defines: N=3\n")


def test_a_link_error_is_reported(ctx, folder):
    folder(
        a_frag=VERSION + "in vec3 v_nobody;\nout vec4 color;\nfloat f();\n"
        "void main() { color = vec4(v_nobody, f()); }\n"
    )
    with pytest.raises(ShaderError, match="a.frag with defines: none"):
        build_program(ctx, "a.frag")


def test_programs_are_cached_by_names_and_defines(ctx, folder):
    folder(a_frag=VERSION + "out vec4 color;\nvoid main() { color = vec4(N); }\n")
    first = build_program(ctx, "a.frag", defines={"N": 1.0})
    assert build_program(ctx, "a.frag", defines={"N": 1.0}) is first
    assert build_program(ctx, "a.frag", defines={"N": 2.0}) is not first
    release_programs(ctx)
    assert isinstance(first.mglo, type(first.mglo)) and not hasattr(first.mglo, "release")
    assert build_program(ctx, "a.frag", defines={"N": 1.0}) is not first
    release_programs(ctx)


def test_a_define_may_be_mentioned_by_one_stage_only(ctx, folder):
    folder(a_frag=VERSION + "out vec4 color;\nvoid main() { color = vec4(N); }\n")
    build_program(ctx, "a.frag", defines={"N": 1.0})
    with pytest.raises(ShaderError, match="fullscreen.vert . a.frag mentions the define.s. M"):
        build_program(ctx, "a.frag", defines={"N": 1.0, "M": 1.0})
    release_programs(ctx)


def test_the_triangle_covers_every_pixel_once(ctx, folder):
    folder(a_frag=VERSION + "out vec4 color;\nvoid main() { color = vec4(gl_FragCoord.xy, 1.0, 1.0); }\n")
    with preserve_state(ctx), Target(ctx, (37, 21)) as target:
        target.framebuffer.use()
        target.framebuffer.clear()
        ctx.enable_only(ctx.BLEND)
        ctx.blend_func = ctx.ONE, ctx.ONE
        full = Fullscreen(ctx, build_program(ctx, "a.frag"))
        full.draw()
        pixels = target.read_color()
        full.release()
    release_programs(ctx)
    y, x = np.mgrid[0:21, 0:37] + 0.5
    np.testing.assert_array_equal(pixels[..., 0], x)
    np.testing.assert_array_equal(pixels[..., 1], y)
    assert np.all(pixels[..., 2] == 1.0)  # added: a pixel drawn twice would be 2


def test_shipped_entry_shaders_begin_right():
    assert read_shader("fullscreen.vert").startswith(VERSION)
