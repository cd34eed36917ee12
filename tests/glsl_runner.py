"""Call functions of the shader libraries on arrays: the plumbing of every test that holds GLSL and twin together."""

import shutil
from importlib.resources import files

import numpy as np

from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.textures import Target


class GlslRunner:
    """Runs a few lines of GLSL over N items, with the library files beside them.

    Parameters
    ----------
    ctx : moderngl.Context
    folder : Path
        Where the composed entry shader is written, next to a copy of the package's shaders.
    """

    def __init__(self, ctx, folder):
        self.ctx, self.folder = ctx, folder / "shaders"
        shutil.copytree(files("shadowatmo.shaders"), self.folder)
        self._count = 0

    def __call__(self, includes, code, inputs, uniforms=None, defines=None, outputs=1, samplers=None):
        """Return the outputs, (N, 4) float32 each (one array for one output).

        `inputs` are arrays (N,) or (N, up to 4), in GLSL the vec4 in0, in1, ...; `code` sets out0, out1, ...
        `samplers` are textures of the libraries by name.
        """
        inputs = [np.asarray(a, np.float32).reshape(len(a), -1) for a in inputs]
        count = len(inputs[0])
        name = f"test_{self._count}.frag"
        self._count += 1
        lines = ["#version 330 core", *(f'#include "{name}"' for name in includes)]
        lines += [f"uniform sampler2D u_in{i};" for i in range(len(inputs))]
        lines += [f"layout(location = {i}) out vec4 out{i};" for i in range(outputs)]
        lines.append("void main() {")
        lines += [f"vec4 in{i} = texelFetch(u_in{i}, ivec2(gl_FragCoord.xy), 0);" for i in range(len(inputs))]
        lines += [f"out{i} = vec4(0.0);" for i in range(outputs)]
        (self.folder / name).write_text("\n".join([*lines, code, "}"]))
        program = build_program(self.ctx, name, defines=defines)
        set_uniforms(program, uniforms or {})
        size = (min(count, 512), -(-count // 512))
        textures = [self._texture(size, values) for values in inputs]
        bind_textures(program, {**(samplers or {}), **{f"u_in{i}": texture for i, texture in enumerate(textures)}})
        draw = Fullscreen(self.ctx, program)
        with Target(self.ctx, size, color=("rgba32f",) * outputs) as target:
            target.framebuffer.use()
            draw.draw()
            result = [target.read_color(i).reshape(-1, 4)[:count].copy() for i in range(outputs)]
        for item in (draw, *textures):
            item.release()
        return result[0] if outputs == 1 else result

    def _texture(self, size, values):
        data = np.zeros((size[0] * size[1], 4), np.float32)
        data[: len(values), : values.shape[1]] = values
        return self.ctx.texture(size, 4, data.tobytes(), dtype="f4")
