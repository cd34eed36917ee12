"""The visible part of the sun for a host's geometry: as a texture over its depth buffer, and as GLSL to include."""

from dataclasses import dataclass

import numpy as np

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.eclipse import Eclipse, eclipse_inputs
from shadowatmo.passes.gl.context import check_alive
from shadowatmo.passes.gl.source import VERSION_LINE, compose_source
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.terminator import terminator_uniforms
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from shadowatmo.passes.widths import host_depth_inputs
from shadowatmo.scene import Scene
from shadowatmo.validation import instance, integer

GL_INT = 0x1404


class SunVisibility(RenderPass):
    """Fraction of one sun left on the surfaces of a host's depth; drawn when somebody asks for it."""

    name = "sun_visibility"
    inputs = ("host_depth",)
    outputs = ("sun_visibility",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=("r32f",)))

    def draw(self, view, textures, sun):
        host = host_depth_inputs(view, textures)
        seen, uniforms, samplers = visible_sun_inputs(sun, textures)
        if "HAS_ECLIPSE" in seen:
            uniforms["u_camera_position"] = view.position
        uniforms |= {**view.depth_uniforms(), **view.axis_uniforms(sun), **host[1]}
        self.target.framebuffer.use()
        defines = {**view.defines(), **host[0], **seen}
        self.fullscreen("sun_visibility.frag", defines, uniforms, {**host[2], **samplers})
        textures["sun_visibility"] = self.target.color[0]


def visible_sun_inputs(sun, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of sunlit.glsl for one sun."""
    moons, discs = eclipse_inputs(sun, textures), terminator_moons_inputs(sun, textures)
    defines = {**moons[0], **discs[0]}
    if sun.disc_at_terminator:
        defines["HAS_TERMINATOR"] = True
    if discs[0]:
        defines["HAS_NO_AIR"] = True
    return defines, {**moons[1], **discs[1], **terminator_uniforms(sun)}, dict(moons[2])


@dataclass(frozen=True, eq=False)
class VisibilitySource:
    """GLSL for a host's shaders, and what it reads.

    Parameters
    ----------
    text : str
        GLSL 3.30 without a version line; declares uniforms and ``float visible_sun(vec3 point)``, the fraction of the
        sun in [0, 1] at a planet-centered point [m].
    uniforms : dict
        Values by name, as NumPy has them: a matrix here is (rows, columns).
    textures : dict
        moderngl.Texture by the name of its sampler; this object's own.
    """

    text: str
    uniforms: dict
    textures: dict
    tables: Eclipse

    def apply(self, program) -> None:
        """Set the uniforms of a host's moderngl.Program and bind the textures, each sampler to a unit of its own.

        Units count from 0: bind your own textures from unit 2 up, and call it before drawing.
        """
        for name, value in self.uniforms.items():
            member = program.get(name, None)
            if member is not None:
                member.write(_glsl_bytes(value, member))
        for unit, (name, texture) in enumerate(self.textures.items()):
            if name in program:
                texture.use(unit)
                program[name].value = unit

    def release(self) -> None:
        """Release the textures."""
        self.tables.release()


def visibility_source(ctx, scene, sun=0) -> VisibilitySource:
    """Return GLSL that tells a host's shaders how much of a sun a point sees past moons, rings and the planet.

    Parameters
    ----------
    ctx : moderngl.Context
        Where the textures are made.
    scene : Scene
        Its text depends on which moons can shade the air, and on nothing else; ask anew when a moon moves.
    sun : int
        Which of the scene's suns.

    Raises
    ------
    ParameterError
        If an argument is malformed. ContextError if the context is gone.
    """
    check_alive(ctx)
    instance("scene", scene, Scene, "a Scene")
    star = scene.suns[integer("sun", sun, low=0, high=len(scene.suns) - 1)]
    tables, textures = Eclipse(ctx), {}
    with preserve_state(ctx):
        tables.draw(scene, textures)
    defines, uniforms, samplers = visible_sun_inputs(star, textures)
    composed = compose_source("host_visibility.frag", defines, optional=defines)
    # A host's compiler counts its own lines.
    lines = [line for line in composed.text.splitlines() if line != VERSION_LINE and not line.startswith("#line")]
    uniforms |= {"u_planet": (*star.direction, scene.atmosphere.bottom_radius)}
    if star.disc_at_terminator:
        uniforms["u_bottom_radius"] = scene.atmosphere.bottom_radius
    return VisibilitySource("\n".join(lines) + "\n", uniforms, samplers, tables)


def _glsl_bytes(value, uniform) -> bytes:
    """Return a value as a moderngl.Uniform takes it, an array cut to what the driver kept of it."""
    array = np.asarray(value, dtype=np.int32 if uniform.gl_type == GL_INT else np.float32)
    if array.shape == (3, 3) and uniform.dimension == 9:
        array = array.T
    elif uniform.array_length > 1:
        array = array[: uniform.array_length]
    elif array.ndim == 2:
        array = array[0]
    return np.ascontiguousarray(array).tobytes()
