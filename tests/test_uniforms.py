"""Feeding programs: uniforms from NumPy, samplers on units of their own, depth textures read as stored."""

import moderngl
import numpy as np
import pytest

from shadowatmo.errors import ShaderError
from shadowatmo.passes.gl.shader import (
    Fullscreen,
    bind_textures,
    build_program,
    release_programs,
    sampler_units,
    set_uniforms,
)
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import Target

VERSION = "#version 330 core\n"


@pytest.fixture
def draw(ctx, folder):
    """Compile a fragment shader, feed it, draw it into one RGBA32F pixel and give that back."""

    def run(text, uniforms=(), textures=(), defines=None):
        folder(test_frag=VERSION + text)
        with preserve_state(ctx), Target(ctx, (1, 1)) as target:
            program = build_program(ctx, "test.frag", defines=defines)
            set_uniforms(program, dict(uniforms))
            bind_textures(program, dict(textures))
            target.framebuffer.use()
            full = Fullscreen(ctx, program)
            full.draw()
            pixel = target.read_color()[0, 0]
            full.release()
            release_programs(ctx)
        return pixel

    return run


# float32 sums of small whole numbers are exact
@pytest.mark.parametrize(
    ("declaration", "expression", "value", "expected"),
    [
        ("float u;", "vec4(u)", 2, [2, 2, 2, 2]),
        ("float u;", "vec4(u)", np.float64(0.5), [0.5] * 4),
        ("int u;", "vec4(u)", 7, [7] * 4),
        ("uint u;", "vec4(u)", 7, [7] * 4),
        ("bool u;", "vec4(u ? 3.0 : 4.0)", True, [3] * 4),
        ("vec3 u;", "vec4(u, 0)", (1, 2, 3), [1, 2, 3, 0]),
        ("ivec2 u;", "vec4(u, 0, 0)", np.array([5, 6]), [5, 6, 0, 0]),
        ("vec3 u[2];", "vec4(u[0] + u[1], 0)", np.arange(6.0).reshape(2, 3), [3, 5, 7, 0]),
        ("vec3 u[1];", "vec4(u[0], 0)", np.arange(3.0).reshape(1, 3), [0, 1, 2, 0]),
        ("float u[3];", "vec4(u[0], u[1], u[2], 0)", [1, 2, 3], [1, 2, 3, 0]),
        (
            "mat4 u;",
            "u * vec4(1, 2, 3, 4)",
            np.arange(16.0).reshape(4, 4),
            np.arange(16.0).reshape(4, 4) @ [1, 2, 3, 4],
        ),
        ("mat3 u;", "vec4(u * vec3(1, 2, 3), 0)", np.arange(9).reshape(3, 3), [8, 26, 44, 0]),
        ("mat4x3 u;", "vec4(u * vec4(1, 2, 3, 4), 0)", np.arange(12.0).reshape(3, 4), [20, 60, 100, 0]),
        (
            "mat2 u[2];",
            "vec4(u[0] * vec2(1, 2), u[1] * vec2(1, 2))",
            np.arange(8.0).reshape(2, 2, 2),
            [2, 8, 14, 20],
        ),
        ("mat3 u;", "vec4(u * vec3(1, 2, 3), 0)", np.arange(9.0).reshape(3, 3).T[::1], [24, 30, 36, 0]),
    ],
)
def test_uniforms_from_numpy(draw, declaration, expression, value, expected):
    text = f"uniform {declaration}\nout vec4 color;\nvoid main() {{ color = vec4({expression}); }}\n"
    np.testing.assert_array_equal(draw(text, {"u": value}), np.array(expected, np.float32))


SIX = (
    "uniform int u_n; uniform vec3 u_v; uniform mat3 u_m; uniform float u_a[2], u_dead;\n"
    "uniform sampler2D u_t;\nout vec4 color;\n"
    "void main() { color = vec4(u_m * u_v, u_n + u_a[0] + u_a[1]) + texture(u_t, u_v.xy); }\n"
)


@pytest.mark.parametrize(
    ("name", "value", "what"),
    [
        ("u_typo", 1.0, "declares no uniform 'u_typo'"),
        ("u_n", 1.5, "integer"),
        ("u_v", (1, 2), r"expects shape \(3,\), got \(2,\)"),
        ("u_v", 1.0, r"expects shape \(3,\), got \(\)"),
        ("u_m", np.eye(4), r"expects shape \(3, 3\)"),
        ("u_m", np.ones(9), r"expects shape \(3, 3\)"),
        ("u_a", [1.0], "expects shape"),
        ("u_t", 0, "bind_textures"),
    ],
)
def test_wrong_uniforms_are_named(draw, name, value, what):
    with pytest.raises(ShaderError, match=what):
        draw(SIX, {name: value})


def test_optimized_out_uniforms_are_ignored(draw):
    draw(SIX, {"u_dead": 1.0})


def test_foreign_programs_are_refused(ctx):
    program = ctx.program(vertex_shader=VERSION + "void main() { gl_Position = vec4(0.0); }\n")
    with pytest.raises(ShaderError, match="not made by build_program"):
        set_uniforms(program, {})
    program.release()


MIXED = (
    "uniform sampler3D b; uniform sampler2D c[2]; uniform sampler2D a; out vec4 color;\n"
    "void main() { color = vec4(texture(a, vec2(0.5)).r, texture(b, vec3(0.5)).r,\n"
    "texture(c[0], vec2(0.5)).r, texture(c[1], vec2(0.5)).r); }\n"
)


def test_samplers_of_different_kinds_have_units_of_their_own(ctx, draw):
    """Left on one unit the draw would fail without a word."""

    def flat(value):
        return ctx.texture((1, 1), 1, np.float32(value).tobytes(), dtype="f4")

    textures = {
        "a": flat(1),
        "b": ctx.texture3d((1, 1, 1), 1, np.float32(2).tobytes(), dtype="f4"),
        "c": [flat(3), flat(4)],
    }
    np.testing.assert_array_equal(draw(MIXED, textures=textures), [1, 2, 3, 4])
    with pytest.raises(ShaderError, match="takes 2 textures, got 1"):
        draw(MIXED, textures={"c": textures["a"]})
    with pytest.raises(ShaderError, match="no uniform 'd'"):
        draw(MIXED, textures={"d": textures["a"]})
    for texture in (textures["a"], textures["b"], *textures["c"]):
        texture.release()


def test_units_are_in_a_fixed_order(ctx, folder):
    folder(a_frag=VERSION + MIXED)
    assert sampler_units(build_program(ctx, "a.frag")) == {"a": 0, "b": 1, "c": 2}
    release_programs(ctx)


def test_a_hosts_comparing_depth_texture_is_read_as_stored(ctx, draw):
    """moderngl's depth textures compare by default, and a sampler2D then reads 0."""
    depth = ctx.depth_texture((1, 1), np.float32(0.625).tobytes())
    read = "uniform sampler2D u_depth; out vec4 color; void main() { color = texture(u_depth, vec2(0.5)); }\n"
    assert draw(read, textures={"u_depth": depth})[0] == pytest.approx(0.625, abs=2.0**-24)  # 24-bit rounding
    imported = ctx.external_texture(depth.glo, (1, 1), 1, 0, "f4")  # as a host's raw name comes in
    assert draw(read, textures={"u_depth": imported})[0] == pytest.approx(0.625, abs=2.0**-24)
    assert depth.compare_func == "<="  # and its own parameters stay
    depth.release()


def test_a_depth_sampler_does_not_stay_for_the_next_texture(ctx, folder):
    """Between two texels, linear filtering gives the mean; a nearest sampler left on the unit would not."""
    read = "uniform sampler2D u; out vec4 color; void main() { color = texture(u, vec2(0.5)); }\n"
    folder(a_frag=VERSION + read)
    depth = ctx.depth_texture((2, 1), np.ones(2, np.float32).tobytes())
    color = ctx.texture((2, 1), 1, np.array([1, 3], np.float32).tobytes(), dtype="f4")
    color.filter = moderngl.LINEAR, moderngl.LINEAR
    with preserve_state(ctx), Target(ctx, (1, 1)) as target:
        program = build_program(ctx, "a.frag")
        bind_textures(program, {"u": depth})
        bind_textures(program, {"u": color})
        target.framebuffer.use()
        full = Fullscreen(ctx, program)
        full.draw()
        full.release()
        assert target.read_color()[0, 0, 0] == 2.0
    release_programs(ctx)
    depth.release()
    color.release()
