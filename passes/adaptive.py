"""Pass 5 at the resolution that the picture needs: the air at the corners of tiles of 8 x 8 pixels, interpolated.

Most of a frame is so smooth that its corners say it all. The other tiles (shaders/adaptive_tiles.frag says which) are
drawn again, as points of a tile's size: by parabolas in the logarithm where these will do, else pixel by pixel, by the
shader that also composes whole frames.
"""

import math

import moderngl
import numpy as np

from shadowatmo.passes.atmosphere import composite_inputs, joined, sun_disc_uniforms
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.eclipse import dimming_rings, shading_occluders
from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.shader import bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.terminator import terminator_inputs
from shadowatmo.passes.widths import cuts_inputs, has_long_paths
from shadowatmo.quality import PATH_METHODS
from shadowatmo.ring import EDGE_ON
from shadowatmo.shadow import penumbra_cone, umbra_cone

TILE = 8  # pixels
CURVED = 4  # kind of the tiles that are interpolated by parabolas
BENDS = ("u_below", "u_above", "u_left", "u_right", "u_clear_across", "u_clear_up")  # of their sides
MIXED = 3  # kind of the tiles, and class of the shader, that may hold pixels of every class
GL_POINT_SIZE_RANGE = 0x0B12
LOBE_REACH = 4.0  # a forward lobe narrower than as many tiles is drawn pixel by pixel within as many of its widths

DRAWN_PER_PIXEL = ("HAS_BACKGROUND", "HAS_SUN_DISC", "HAS_MOONS", "MOONS")  # what samples do not hold
DISC_UNIFORMS = ("u_sun_disc", "u_sun_toward", "u_pixel_angle", "u_moons")


class AdaptiveComposite(RenderPass):
    """The composite of one sun after the other: grid, kinds of tiles, the interpolated frame, the tiles refused."""

    name = "adaptive"
    outputs = ("color",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self.tiles_across = tuple(-(-n // TILE) for n in size)
        samples = tuple(n + 1 for n in self.tiles_across)
        self.grid = self.own(Target(ctx, samples, color=("rgba32f", "rgba32f")))
        for texture in self.grid.color:
            texture.filter = (ctx.LINEAR, ctx.LINEAR)
        self.tiles = self.own(Target(ctx, self.tiles_across, color=("r32f", *(("rgba32f",) * len(BENDS)))))
        self.target = self.own(Target(ctx, size, color=("rgba32f",)))
        self.points = gl_functions(ctx).floats(GL_POINT_SIZE_RANGE, 2)[1] >= TILE
        self._arrays = {}

    def draw(self, view, textures, sun, first):
        seen, air, class_features = composite_inputs(view, textures, sun, first)
        air = joined(air, terminator_inputs(view, sun, textures))
        cuts = cuts_inputs(view, textures, sun)
        grid = {"u_light": self.grid.color[0], "u_clear": self.grid.color[1]}
        self._draw_grid(seen, air, cuts, class_features[MIXED])
        self._draw_tiles(view, sun, seen, cuts, grid)
        self._draw_frame(seen, grid, first)
        self.ctx.enable(moderngl.PROGRAM_POINT_SIZE)
        self._draw_curved(seen, grid)
        for kind, features in enumerate(class_features[1 : MIXED + 1], 1):
            own = {"HAS_SOLVED_CUTS": True, "TILE_PIXELS": TILE, **features}, {"u_kind": kind}, {}
            self._draw_points("atmosphere.frag", "adaptive_tile.vert", *joined(seen, air, cuts, own))
        self.ctx.disable(moderngl.PROGRAM_POINT_SIZE)
        self.ctx.disable(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ZERO
        textures["color"] = self.target.color[0]

    def _draw_grid(self, seen, air, cuts, features):
        own = {"TILE_PIXELS": TILE, **features}, {"u_size": self.size}, {}
        defines, uniforms, samplers = joined((*seen[:2], {}), air, cuts, own)
        kept = {name: value for name, value in defines.items() if name not in DRAWN_PER_PIXEL}
        self.grid.framebuffer.use()
        uniforms = {name: value for name, value in uniforms.items() if name not in DISC_UNIFORMS}
        self.fullscreen("adaptive_grid.frag", kept, uniforms, samplers)

    def _draw_tiles(self, view, sun, seen, cuts, grid):
        defines, uniforms, samplers = cuts
        defines = {**defines, "TILE_PIXELS": TILE}
        uniforms = {**uniforms, "u_size": self.size, "u_tolerance": view.quality.tolerance, "u_peak": peak(view)}
        samplers = {**samplers, **grid}
        if {"HAS_PLANET_DEPTH", "HAS_HOST_DEPTH"} & set(defines):
            defines["HAS_DRAWN_DEPTH"] = True
        if "HAS_BACKGROUND" in seen[0]:
            defines["HAS_BACKGROUND"] = True
            samplers["u_background"] = seen[2]["u_background"]
        if view.scene.sun_disc:
            defines["HAS_SUN_DISC"] = True
            uniforms["u_disc"] = disc_reach(view, sun)
        moons = shading_occluders(view.scene, sun)
        if moons and view.quality.method in PATH_METHODS:
            defines |= {"HAS_ECLIPSE": True, "OCCLUDERS": len(moons)}
            uniforms |= moon_shadows(view, sun, moons)
        rings = dimming_rings(view.scene, sun)
        if rings and view.quality.method in PATH_METHODS:
            defines |= {"HAS_RINGS": True, "RINGS": len(rings)}
            uniforms |= ring_shadows(view, sun, rings)
        if (moons or rings) and has_long_paths(view):  # what is not smooth along a path depends on where its nodes are
            defines["HAS_LONG_PATHS"] = True
        self.tiles.framebuffer.use()
        self.fullscreen("adaptive_tiles.frag", defines, uniforms, samplers, vertex="adaptive_tiles.vert")

    def _draw_frame(self, seen, grid, first):
        defines, samplers = {"TILE_PIXELS": TILE}, {"u_light": grid["u_light"]}
        if "HAS_BACKGROUND" in seen[0]:
            defines["HAS_BACKGROUND"] = True
            samplers |= {"u_clear": grid["u_clear"], "u_background": seen[2]["u_background"]}
        if not first:
            defines["HAS_TILES"] = True
            samplers["u_tiles"] = self.tiles.color[0]
            self.ctx.enable(moderngl.BLEND)
            self.ctx.blend_func = moderngl.ONE, moderngl.ONE, moderngl.ZERO, moderngl.ONE
        self.target.framebuffer.use()
        uniforms = {"u_grid": 1.0 / np.array(self.grid.size)}
        self.fullscreen("adaptive_reconstruct.frag", defines, uniforms, samplers)

    def _draw_curved(self, seen, grid):
        defines, samplers = {"TILE_PIXELS": TILE}, {"u_light": grid["u_light"]}
        samplers |= dict(zip(BENDS[:4], self.tiles.color[1:5], strict=True))
        if "HAS_BACKGROUND" in seen[0]:
            defines["HAS_BACKGROUND"] = True
            samplers |= dict(zip(BENDS[4:], self.tiles.color[5:], strict=True))
            samplers |= {"u_clear": grid["u_clear"], "u_background": seen[2]["u_background"]}
        self._draw_points("adaptive_curved.frag", "adaptive_curved.vert", defines, {"u_kind": CURVED}, samplers)

    def _draw_points(self, fragment, vertex, defines, uniforms, samplers):
        framebuffer = self.target.framebuffer
        if not self.points:
            defines = {**defines, "HAS_TRIANGLES": True}
        program = build_program(self.ctx, fragment, vertex=vertex, defines=defines)
        set_uniforms(program, uniforms)
        bind_textures(program, {**samplers, "u_tiles": self.tiles.color[0]})
        if program not in self._arrays:
            self._arrays[program] = self.own(self.ctx.vertex_array(program, []))
        # Whole tiles: a point whose middle is outside of the viewport would be clipped.
        framebuffer.viewport = 0, 0, *(TILE * n for n in self.tiles_across)
        mode, vertices = (moderngl.POINTS, 1) if self.points else (moderngl.TRIANGLES, 6)
        self._arrays[program].render(mode, vertices=vertices * math.prod(self.tiles_across))
        framebuffer.viewport = 0, 0, *self.size


def peak(view) -> tuple[float, float]:
    """Return the sine of the angle from the sun in which a peak of the sky may hide between samples, and its side.

    0 where there is none; the side is -1 for a lobe that scatters back.
    """
    tile = math.sqrt(0.5) * TILE * view.pixel_angle
    g = view.scene.atmosphere.mie_g
    lobe = 1.0 - abs(g)
    reach = LOBE_REACH * lobe if lobe < LOBE_REACH * tile else 0.0
    return min(reach, 1.0), 1.0 if g > 0.0 else -1.0


def disc_reach(view, sun) -> tuple[float, float, float, float]:
    """Return the unit vector to a sun's disc and the sine of the angle that it takes, its soft edge included."""
    disc = sun_disc_uniforms(view, sun)
    return *disc["u_sun_toward"], min(disc["u_sun_disc"][0] + view.pixel_angle, 1.0)


def moon_shadows(view, sun, moons) -> dict:
    """Return axes and cones of the moons' shadows as the camera sees them, worked out in float64."""
    off, axes, cones = [], [], []
    for moon in moons:
        center = np.array(moon.center)
        from_sun = center - sun.distance * np.array(sun.direction)
        distance = float(np.linalg.norm(from_sun))
        axis = from_sun / distance
        relative = view.position - center
        along = relative @ axis
        off.append((*(along * axis - relative), along))
        axes.append((*axis, 0.0))
        outer, umbra = (make(moon.radius, sun.radius, distance) for make in (penumbra_cone, umbra_cone))
        cones.append((outer.radius + outer.excess, -outer.slope, umbra.radius + umbra.excess, umbra.slope))
    return {"u_moon_off": np.array(off), "u_moon_axis": np.array(axes), "u_moon_cones": np.array(cones)}


def ring_shadows(view, sun, rings) -> dict:
    """Return planes and edges of rings as the camera sees them, worked out in float64."""
    offsets = [np.array(ring.center) - view.position for ring in rings]
    normals = [np.array(ring.normal) for ring in rings]
    slants = [_signed_floor(normal @ sun.direction, EDGE_ON) for normal in normals]
    return {
        "u_ring_planes": np.array([(*n, n @ off) for n, off in zip(normals, offsets, strict=True)]),
        "u_ring_centers": np.array([(*off, slant) for off, slant in zip(offsets, slants, strict=True)]),
        "u_ring_radii": np.array([(ring.inner_radius, ring.outer_radius) for ring in rings]),
    }


def _signed_floor(value, least):
    return math.copysign(max(abs(value), least), value)
