"""Pass 3: color and depth of the planet, a sphere with the surface's color, and its relief when the camera is near."""

import math

import moderngl
import numpy as np

from shadowatmo.eclipse_multiple import RATIO_RECIPES
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.canvas import Canvas
from shadowatmo.passes.constants import (
    cone_uniforms,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    transmittance_defines,
)
from shadowatmo.passes.eclipse import eclipse_inputs
from shadowatmo.passes.eclipse_multiple import ratio_inputs
from shadowatmo.passes.gl.shader import bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple import multiple_defines, multiple_samplers, multiple_uniforms
from shadowatmo.passes.surface_maps import SurfaceMaps
from shadowatmo.passes.terminator import terminator_defines, terminator_uniforms
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from shadowatmo.passes.transmittance import table_samplers
from shadowatmo.quality import Quality

MIRRORED_SKY = Quality(nodes=4, gap_nodes=2)  # effort for the sky in the sea
FAN = 64  # triangles of the fan over the planet
FAN_MARGIN = 2e-4  # rad
FAN_LIMIT = math.radians(110.0)  # from the nadir, beyond which the whole picture is as good
RINGS, SPOKES = 256, 384
FIRST_RING = 0.5  # m from the point below the camera, or a thousandth of the altitude
RELIEF_CEILING = 1e6  # m; above it the relief is far below a pixel and the smooth sphere, lit by its slopes, is enough


class Planet(RenderPass):
    """The ground, lit by the suns through the air (Schafhitzel et al. 2007, eq. 9-12), without the air before it.

    Geometry comes first, the sphere and near the ground the relief before it; the light is worked out once for each
    pixel after that.
    """

    name = "planet"
    outputs = ("planet_color", "planet_depth")

    def __init__(self, ctx, size, depth_format, surface):
        super().__init__(ctx, size)
        self.geometry = self.own(Target(ctx, size, color=("r32f",), depth=depth_format))
        self.reversed = depth_format == "d32f"
        self.canvas, self.maps, self._relief, self._fans = None, None, None, {}
        if surface is not None:
            self.maps = self.own(SurfaceMaps.acquire(ctx, surface))
        if self.maps is not None and self.maps.relief is not None:
            self._relief = self.own(Relief(ctx, self.maps))

    def draw(self, view, textures):
        # A bare sphere has a closed form, which the passes after this one know too.
        solved = view.quality.depth == "analytic" and self.highest_in_view(view) == 0.0
        if not solved:
            self._draw_geometry(view)
            textures["planet_depth"] = self.geometry.depth
        if self.maps is None:
            return
        canvas = textures.get("canvas") or self._own_canvas()
        canvas.clear()
        canvas.mark(view.air_window)
        self.ctx.enable(moderngl.BLEND)  # the light of several suns adds up
        self.ctx.blend_func = moderngl.ONE, moderngl.ONE
        for sun in view.scene.suns:
            defines, uniforms, samplers = self._shading(view, sun, textures)
            if not solved:
                defines["HAS_GEOMETRY"] = True
                samplers["u_planet_distance"] = self.geometry.color[0]
            self._draw_fan("planet.frag", view, self.highest_in_view(view), defines, uniforms, samplers)
        self.ctx.disable(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ZERO
        textures["planet_color"] = canvas.color

    def _own_canvas(self):
        """Return the picture for composites that read the surface and write another one."""
        if self.canvas is None:
            self.canvas = self.own(Canvas(self.ctx, self.size))
        return self.canvas

    def highest_in_view(self, view) -> float:
        """Altitude [m] of the highest relief that is drawn displaced for a view."""
        return self.maps.highest if has_relief_in_view(view) else 0.0

    def _draw_geometry(self, view):
        framebuffer = self.geometry.framebuffer
        framebuffer.use()
        framebuffer.clear(depth=0.0 if self.reversed else 1.0)
        with depth_test(self.ctx, ">" if self.reversed else "<"):
            self._draw_fan("planet_depth.frag", view, 0.0, view.defines(), view.depth_uniforms(), {})
            if self.highest_in_view(view) > 0.0:
                self._relief.draw(view)

    def _draw_fan(self, fragment, view, highest, defines, uniforms, samplers):
        """Draw over the pixels that can show the sphere, or relief on it up to `highest` [m]."""
        angle = fan_angle(view, highest)
        if angle is None:
            self.fullscreen(fragment, defines, uniforms, samplers)
            return
        program = build_program(self.ctx, fragment, vertex="cone.vert", defines={**defines, "FAN": FAN})
        local = {"u_local": local_axes(view), "u_view": view_rows(view), "u_cone": (math.cos(angle), math.sin(angle))}
        set_uniforms(program, {**uniforms, **local})
        bind_textures(program, samplers)
        if program not in self._fans:
            self._fans[program] = self.own(self.ctx.vertex_array(program, []))
        self._fans[program].render(moderngl.TRIANGLES, vertices=3 * FAN)

    def _shading(self, view, sun, textures):
        """Return defines, uniforms and samplers of the surface in the light of one sun."""
        atmosphere = view.scene.atmosphere
        defines = {**({"HAS_FAR_CAMERA": True} if view.is_far else {}), **self.maps.defines()}
        defines |= {**medium_defines(atmosphere), **transmittance_defines(atmosphere, view.quality)}
        uniforms = {**view.camera_uniforms(), **medium_uniforms(atmosphere), **view.axis_uniforms(sun)}
        uniforms |= {
            "u_irradiance": sun.irradiance,
            "u_ground_albedo": atmosphere.ground_albedo,
            "u_pixel_angle": view.pixel_angle,
            "u_camera_up": view.up,
            "u_camera_radius": view.radius,
        }
        samplers = self.maps.textures()
        if "multiple_table" in textures:
            defines |= multiple_defines(RECIPES[view.quality.multiple])
            uniforms |= multiple_uniforms(atmosphere)
            samplers |= multiple_samplers(textures)
        if "HAS_WATER" in defines:
            defines |= {"HAS_SHADOW": True, "HAS_TWO_PIECES": True, **segment_defines(MIRRORED_SKY, atmosphere)}
            uniforms |= {**segment_uniforms(atmosphere), **cone_uniforms("u_shadow", view.shadow_cone(sun))}
        defines |= terminator_defines(sun, view.quality)
        uniforms |= terminator_uniforms(sun)
        moons = eclipse_inputs(sun, textures)
        ratio = ratio_inputs(view.scene, sun, textures, RATIO_RECIPES[view.quality.multiple])
        disc = terminator_moons_inputs(sun, textures)
        moons = tuple({**a, **b, **c} for a, b, c in zip(moons, ratio, disc, strict=True))
        samplers |= table_samplers(uniforms, textures)
        return {**defines, **moons[0]}, {**uniforms, **moons[1]}, {**samplers, **moons[2]}


class Relief:
    """The displaced relief about the point below the camera, out to where its highest sinks behind the horizon."""

    def __init__(self, ctx, maps):
        self.ctx, self.maps = ctx, maps
        vertices, indices = polar_grid()
        self._buffers = ctx.buffer(vertices.tobytes()), ctx.buffer(indices.tobytes())
        self._arrays = {}

    def draw(self, view):
        program = build_program(self.ctx, "terrain.frag", vertex="terrain.vert", defines=view.defines())
        radius, altitude = view.scene.atmosphere.bottom_radius, max(view.altitude, 0.0)
        reach = dip(radius, altitude) + dip(radius, self.maps.highest)
        uniforms = {
            **view.depth_uniforms(),
            "u_local": local_axes(view),
            "u_view": view_rows(view),
            "u_camera_altitude": view.altitude,
            "u_ring_angles": (max(FIRST_RING, 1e-3 * altitude) / radius, min(1.02 * reach, math.pi)),
        }
        set_uniforms(program, uniforms)
        bind_textures(program, {"u_relief_map": self.maps.relief})
        if program not in self._arrays:
            content = [(self._buffers[0], "2f", "in_grid")]
            self._arrays[program] = self.ctx.vertex_array(program, content, self._buffers[1])
        self.ctx.enable(moderngl.CULL_FACE)  # seen from below, the relief would hide the sky of a camera inside it
        self.ctx.cull_face = "back"
        self._arrays[program].render(moderngl.TRIANGLES)
        self.ctx.disable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Release the grid."""
        for item in (*self._arrays.values(), *self._buffers):
            item.release()


def has_relief_in_view(view) -> bool:
    """Return whether the ground of a view is more than a sphere: whether relief is displaced."""
    surface = view.scene.surface
    return surface is not None and surface.height is not None and view.altitude < RELIEF_CEILING


def dip(radius, altitude) -> float:
    """Return the angle [rad] by which the horizon lies below the horizontal, seen from an altitude [m]."""
    return math.acos(radius / (radius + altitude))


def fan_angle(view, highest) -> float | None:
    """Return the angle from the nadir [rad] of a fan over the planet and its relief; None: the whole picture."""
    radius = view.scene.atmosphere.bottom_radius
    if view.altitude <= 0.0:
        return None
    planet = 0.5 * math.pi - dip(radius, view.altitude)
    angle = planet + dip(radius, highest) + min(FAN_MARGIN, FAN_MARGIN * planet)
    if angle > FAN_LIMIT:
        return None
    if angle >= 0.5 * math.pi:
        return angle
    # Up to the horizontal the middle of an edge of the fan is nearer to the nadir than its corners.
    return math.atan2(math.sin(angle), math.cos(angle) * math.cos(math.pi / FAN))


def local_axes(view) -> np.ndarray:
    """Return two horizontal axes and the up vector at the camera, as the columns of (3, 3)."""
    east = np.cross([0.0, 0.0, 1.0], view.up) if abs(view.up[2]) < 0.999 else np.cross([1.0, 0.0, 0.0], view.up)
    east /= np.linalg.norm(east)
    return np.stack([east, np.cross(view.up, east), view.up], axis=1)


def view_rows(view) -> np.ndarray:
    """Return right and up over the tangents of the half angles, and forward, as the rows of (3, 3)."""
    tan_x, tan_y = view.camera.tangents(view.size)
    return view.camera.basis() / np.array([[tan_x], [tan_y], [1.0]])


def polar_grid() -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 2) float32 (ring, azimuth, both in 0..1) and triangle indices (m,) uint32."""
    ring, spoke = np.meshgrid(np.arange(RINGS + 1), np.arange(SPOKES + 1), indexing="ij")
    vertices = np.stack([ring / RINGS, spoke / SPOKES], axis=-1).reshape(-1, 2).astype(np.float32)
    corner = (np.arange(RINGS)[:, None] * (SPOKES + 1) + np.arange(SPOKES)).ravel()
    across = SPOKES + 1
    quads = np.stack([corner, corner + across, corner + across + 1, corner, corner + across + 1, corner + 1], axis=1)
    return vertices, quads.ravel().astype(np.uint32)
