"""Pass 3: color and depth of the planet, a sphere with the surface's color, and its relief when the camera is near."""

import math

import moderngl
import numpy as np

from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.constants import (
    cone_uniforms,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    transmittance_defines,
)
from shadowatmo.passes.eclipse import eclipse_inputs
from shadowatmo.passes.gl.shader import bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple import multiple_defines, multiple_samplers, multiple_uniforms
from shadowatmo.passes.surface_maps import SurfaceMaps
from shadowatmo.passes.transmittance import table_samplers
from shadowatmo.quality import Quality

MIRRORED_SKY = Quality(nodes=4, gap_nodes=2)  # effort for the sky in the sea
RINGS, SPOKES = 256, 384
FIRST_RING = 0.5  # m from the point below the camera, or a thousandth of the altitude
RELIEF_CEILING = 1e6  # m; above it the relief is far below a pixel and the smooth sphere, lit by its slopes, is enough


class Planet(RenderPass):
    """The ground, lit by the suns through the air (Schafhitzel et al. 2007, eq. 9-12), without the air before it."""

    name = "planet"
    outputs = ("planet_color", "planet_depth")

    def __init__(self, ctx, size, depth_format, surface):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=("rgba32f",), depth=depth_format))
        self.reversed = depth_format == "d32f"
        self.maps = self.own(SurfaceMaps.acquire(ctx, surface)) if surface is not None else None
        self._grid, self._arrays = None, {}

    def draw(self, view, textures):
        framebuffer = self.target.framebuffer
        framebuffer.use()
        framebuffer.clear(depth=0.0 if self.reversed else 1.0)
        for number, sun in enumerate(view.scene.suns if self.maps is not None else view.scene.suns[:1]):
            defines, uniforms, maps = self._shading(view, sun, textures)
            uniforms |= {"u_camera_up": view.up, "u_camera_radius": view.radius}
            if number > 0:  # the light of a further sun is added where its surface is the one in view
                self.ctx.enable(moderngl.BLEND)
                self.ctx.blend_func = moderngl.ONE, moderngl.ONE
            nearer = ">" if self.reversed else "<"
            with depth_test(self.ctx, nearer if number == 0 else nearer + "="):
                self.fullscreen("planet.frag", defines, uniforms, maps)
                if self.shows_relief(view):
                    self._draw_relief(view, defines, uniforms, maps)
        self.ctx.disable(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ZERO
        textures["planet_color"], textures["planet_depth"] = self.target.color[0], self.target.depth

    def shows_relief(self, view) -> bool:
        """Whether the displaced relief is drawn for a view."""
        return self.maps is not None and self.maps.relief is not None and view.altitude < RELIEF_CEILING

    def _shading(self, view, sun, textures):
        """Return defines, uniforms and textures of the surface in the light of one sun."""
        scene = view.scene
        defines = view.defines()
        uniforms = {**view.depth_uniforms()}
        if self.maps is None:
            return defines, uniforms, {}
        defines |= {"HAS_SURFACE": True, **self.maps.defines()}
        defines |= {**medium_defines(scene.atmosphere), **transmittance_defines(scene.atmosphere, view.quality)}
        uniforms |= {**medium_uniforms(scene.atmosphere), **view.axis_uniforms(sun)}
        uniforms |= {
            "u_irradiance": sun.irradiance,
            "u_ground_albedo": scene.atmosphere.ground_albedo,
            "u_pixel_angle": view.pixel_angle,
        }
        samplers = self.maps.textures()
        if "multiple_table" in textures:
            defines |= multiple_defines(RECIPES[view.quality.multiple])
            uniforms |= multiple_uniforms(scene.atmosphere)
            samplers |= multiple_samplers(textures)
        if "HAS_WATER" in defines:
            defines |= {"HAS_SHADOW": True, "HAS_TWO_PIECES": True, **segment_defines(MIRRORED_SKY, scene.atmosphere)}
            uniforms |= {**segment_uniforms(scene.atmosphere), **cone_uniforms("u_shadow", view.shadow_cone(sun))}
        moons = eclipse_inputs(view.scene, sun, textures)
        samplers |= table_samplers(uniforms, textures)
        return {**defines, **moons[0]}, {**uniforms, **moons[1]}, {**samplers, **moons[2]}

    def _draw_relief(self, view, defines, uniforms, maps):
        """Draw the polar grid below the camera, out to where the highest relief sinks behind the horizon."""
        radius = view.scene.atmosphere.bottom_radius
        highest = self.maps.highest
        altitude = max(view.altitude, 0.0)
        reach = math.acos(radius / (radius + altitude)) + math.acos(radius / (radius + highest))
        first = max(FIRST_RING, 1e-3 * altitude) / radius
        east = np.cross([0.0, 0.0, 1.0], view.up) if abs(view.up[2]) < 0.999 else np.cross([1.0, 0.0, 0.0], view.up)
        east /= np.linalg.norm(east)
        tan_x, tan_y = view.camera.tangents(view.size)
        uniforms = {
            **uniforms,
            "u_local": np.stack([east, np.cross(view.up, east), view.up], axis=1),
            "u_view": view.camera.basis() / np.array([[tan_x], [tan_y], [1.0]]),
            "u_camera_altitude": view.altitude,
            "u_ring_angles": (first, min(1.02 * reach, math.pi)),
        }
        defines = {name: value for name, value in defines.items() if name != "HAS_SURFACE"}
        program = build_program(self.ctx, "terrain.frag", vertex="terrain.vert", defines=defines)
        set_uniforms(program, {n: v for n, v in uniforms.items() if n not in ("u_camera_up", "u_camera_radius")})
        bind_textures(program, maps)
        self.ctx.enable(moderngl.CULL_FACE)  # seen from below, the relief would hide the sky of a camera inside it
        self.ctx.cull_face = "back"
        self._relief_array(program).render(moderngl.TRIANGLES)
        self.ctx.disable(moderngl.CULL_FACE)

    def _relief_array(self, program):
        """Return the grid bound to a program; made once."""
        if self._grid is None:
            vertices, indices = polar_grid()
            self._grid = (
                self.own(self.ctx.buffer(vertices.tobytes())),
                self.own(self.ctx.buffer(indices.tobytes())),
            )
        if program not in self._arrays:
            content = [(self._grid[0], "2f", "in_grid")]
            self._arrays[program] = self.own(self.ctx.vertex_array(program, content, self._grid[1]))
        return self._arrays[program]


def polar_grid() -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 2) float32 (ring, azimuth, both in 0..1) and triangle indices (m,) uint32."""
    ring, spoke = np.meshgrid(np.arange(RINGS + 1), np.arange(SPOKES + 1), indexing="ij")
    vertices = np.stack([ring / RINGS, spoke / SPOKES], axis=-1).reshape(-1, 2).astype(np.float32)
    corner = (np.arange(RINGS)[:, None] * (SPOKES + 1) + np.arange(SPOKES)).ravel()
    across = SPOKES + 1
    quads = np.stack([corner, corner + across, corner + across + 1, corner, corner + across + 1, corner + 1], axis=1)
    return vertices, quads.ravel().astype(np.uint32)
