"""What every pass has in common: its inputs and outputs as data, and how it draws."""

from contextlib import contextmanager

import moderngl

from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, set_uniforms
from shadowatmo.passes.view import View
from shadowatmo.plan import Step


@contextmanager
def depth_test(ctx, comparison):
    """Test and write depth by a comparison of moderngl ("1": always), and leave the test off again."""
    ctx.enable(moderngl.DEPTH_TEST)
    ctx.depth_func = comparison
    try:
        yield
    finally:
        ctx.disable(moderngl.DEPTH_TEST)


class RenderPass:
    """A pass of the pipeline: declares what it reads and writes, and draws into targets that it owns.

    Subclasses set the class attributes, and implement `draw`. The order of the passes and the check that every input is
    written before it is read come from these declarations alone.

    Attributes
    ----------
    name : str
        Also the name of the file in passes/ and of the entry shader.
    inputs, outputs : tuple of str
        Names of textures.
    """

    name: str
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()

    def __init__(self, ctx, size):
        self.ctx, self.size = ctx, size
        self._owned = []

    def own(self, resource):
        """Keep a resource until `release`, and return it."""
        self._owned.append(resource)
        return resource

    def release(self) -> None:
        """Release everything that the pass made."""
        self.__dict__.pop("_triangles", None)
        while self._owned:
            self._owned.pop().release()

    def step(self, reason) -> Step:
        """Return this pass as a step of a plan."""
        return Step(self.name, reason, self.inputs, self.outputs)

    def draw(self, view: View, textures: dict) -> None:
        """Draw one frame: read `inputs` from `textures`, put `outputs` there."""
        raise NotImplementedError

    def fullscreen(self, fragment, defines, uniforms, textures=None, vertex="fullscreen.vert") -> None:
        """Draw one triangle over the bound framebuffer."""
        program = build_program(self.ctx, fragment, vertex=vertex, defines=defines)
        set_uniforms(program, uniforms)
        bind_textures(program, textures or {})
        triangle = self.__dict__.setdefault("_triangles", {})
        if program not in triangle:
            triangle[program] = self.own(Fullscreen(self.ctx, program))
        triangle[program].draw()
