"""Pass 5 at the resolution that the picture needs: the air at the corners of tiles of 8 x 8 pixels, interpolated.

Most of a frame is so smooth that its corners say it all. The other tiles (shaders/adaptive_tiles.frag says which) are
drawn again, as points of a tile's size: by parabolas in the logarithm where these will do, else pixel by pixel, by the
shader that also composes whole frames.
"""

import math

import moderngl
import numpy as np

from shadowatmo.passes.atmosphere import composite_inputs, draw_disc, joined, prepare, without_background
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.canvas import ADDED, IN_HOST, IN_PLACE, Canvas, blended, drawing_in
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

DRAWN_PER_PIXEL = ("HAS_BACKGROUND", "HAS_IN_PLACE", "HAS_SUN_DISC", "HAS_MOONS", "MOONS")  # what samples do not hold
DISC_UNIFORMS = ("u_sun_disc", "u_sun_toward", "u_pixel_angle", "u_moons")


class AdaptiveComposite(RenderPass):
    """The composite of one sun after the other: grid, kinds of tiles, the interpolated frame, the tiles refused.

    Only the window of the frame that may show air is drawn. Where the scene behind the air stands in the picture
    already (`textures["canvas"]`) it is dimmed and lit in place, by blending; else the first sun writes the window.

    Parameters
    ----------
    ctx : moderngl.Context
    size : (int, int)
        Of the frame [pixels].
    blends : bool
        Whether it can draw in place.
    """

    name = "adaptive"
    outputs = ("color",)

    def __init__(self, ctx, size, blends):
        super().__init__(ctx, size)
        self.tiles_across = tuple(-(-n // TILE) for n in size)
        samples = tuple(n + 1 for n in self.tiles_across)
        self.grid = self.own(Target(ctx, samples, color=("rgba32f", "rgba32f")))
        for texture in self.grid.color:
            texture.filter = (ctx.LINEAR, ctx.LINEAR)
        self.tiles = self.own(Target(ctx, self.tiles_across, color=("r32f", *(("rgba32f",) * len(BENDS)))))
        self.tiles.framebuffer.clear()
        self.points = gl_functions(ctx).floats(GL_POINT_SIZE_RANGE, 2)[1] >= TILE
        self.blends, self._canvas, self._arrays = blends, None, {}

    @property
    def canvas(self) -> Canvas:
        """The picture of our own, made when it is needed."""
        if self._canvas is None:
            self._canvas = self.own(Canvas(self.ctx, self.size))
        return self._canvas

    def draw(self, view, textures, sun, first):
        canvas, in_place = textures.get("canvas") or self.canvas, "canvas" in textures
        window, disc = view.windows(sun, TILE)
        seen, air, class_features = composite_inputs(view, textures, sun, first)
        behind = seen[2].get("u_background")
        cuts = cuts_inputs(view, textures, sun)
        if first and not in_place:
            prepare(self, canvas, window, behind)
        canvas.mark(window, disc)
        if window is not None:
            if first and in_place:
                seen = {**without_background(seen), "HAS_IN_PLACE": True}, seen[1], {}
            air = joined(air, terminator_inputs(view, sun, textures))
            grid = {"u_light": self.grid.color[0], "u_clear": self.grid.color[1]}
            tiles = tiles_of(window)
            self._draw_grid(seen, air, cuts, class_features[MIXED], tiles)
            self._draw_tiles(view, sun, behind, cuts, grid, tiles)
            with blended(self.ctx, blending(first, in_place, canvas)):
                self._draw_frame(seen[0], behind, grid, first, canvas, window)
                self._draw_classes(seen, behind, air, cuts, grid, class_features, canvas, tiles)
        if disc is not None:
            draw_disc(self, canvas, disc, seen, cuts)
        textures["color"] = canvas.color

    def _draw_grid(self, seen, air, cuts, features, tiles):
        own = {"TILE_PIXELS": TILE, **features}, {"u_size": self.size}, {}
        defines, uniforms, samplers = joined((*seen[:2], {}), air, cuts, own)
        kept = {name: value for name, value in defines.items() if name not in DRAWN_PER_PIXEL}
        uniforms = {name: value for name, value in uniforms.items() if name not in DISC_UNIFORMS}
        with drawing_in(self.grid.framebuffer, samples_of(tiles, self.grid.size)):
            self.fullscreen("adaptive_grid.frag", kept, uniforms, samplers)

    def _draw_tiles(self, view, sun, behind, cuts, grid, tiles):
        defines, uniforms, samplers = cuts
        defines = {**defines, "TILE_PIXELS": TILE}
        uniforms = {**uniforms, "u_size": self.size, "u_tolerance": view.quality.tolerance, "u_peak": peak(view)}
        uniforms["u_samples"] = tiles[0], tiles[1], tiles[2] + 1, tiles[3] + 1
        samplers = {**samplers, **grid}
        if {"HAS_PLANET_DEPTH", "HAS_HOST_DEPTH"} & set(defines):
            defines["HAS_DRAWN_DEPTH"] = True
        if behind is not None:
            defines["HAS_BACKGROUND"] = True
            samplers["u_background"] = behind
        if view.scene.sun_disc:
            defines["HAS_SUN_DISC"] = True
            uniforms["u_disc"] = view.disc_reach(sun)
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
        with drawing_in(self.tiles.framebuffer, tiles):
            self.fullscreen("adaptive_tiles.frag", defines, uniforms, samplers, vertex="adaptive_tiles.vert")

    def _draw_frame(self, seen, behind, grid, first, canvas, window):
        defines, samplers = {"TILE_PIXELS": TILE}, {"u_light": grid["u_light"]}
        in_place = "HAS_IN_PLACE" in seen
        if in_place:
            defines["HAS_IN_PLACE"] = True
            samplers["u_clear"] = grid["u_clear"]
        elif behind is not None:
            defines["HAS_BACKGROUND"] = True
            samplers |= {"u_clear": grid["u_clear"], "u_background": behind}
        if in_place or not first:
            defines["HAS_TILES"] = True
            samplers["u_tiles"] = self.tiles.color[0]
        uniforms = {"u_grid": 1.0 / np.array(self.grid.size)}
        with drawing_in(canvas.framebuffer, window):
            self.fullscreen("adaptive_reconstruct.frag", defines, uniforms, samplers)

    def _draw_classes(self, seen, behind, air, cuts, grid, class_features, canvas, tiles):
        self.ctx.enable(moderngl.PROGRAM_POINT_SIZE)
        # Whole tiles: a point whose middle is outside of the viewport would be clipped.
        with drawing_in(canvas.framebuffer, (0, 0, *(TILE * n for n in self.tiles_across))):
            self._draw_curved(seen[0], behind, grid, tiles)
            for kind, features in enumerate(class_features[1 : MIXED + 1], 1):
                own = {"HAS_SOLVED_CUTS": True, "TILE_PIXELS": TILE, **features}, {"u_kind": kind}, {}
                self._draw_points("atmosphere.frag", "adaptive_tile.vert", joined(seen, air, cuts, own), tiles)
        self.ctx.disable(moderngl.PROGRAM_POINT_SIZE)

    def _draw_curved(self, seen, behind, grid, tiles):
        defines, samplers = {"TILE_PIXELS": TILE}, {"u_light": grid["u_light"]}
        samplers |= dict(zip(BENDS[:4], self.tiles.color[1:5], strict=True))
        if behind is not None:
            defines["HAS_CLEAR"] = True
            samplers |= {"u_clear": grid["u_clear"], **dict(zip(BENDS[4:], self.tiles.color[5:], strict=True))}
        if "HAS_IN_PLACE" in seen:
            defines["HAS_IN_PLACE"] = True
        elif behind is not None:
            defines["HAS_BACKGROUND"] = True
            samplers["u_background"] = behind
        self._draw_points(
            "adaptive_curved.frag", "adaptive_curved.vert", (defines, {"u_kind": CURVED}, samplers), tiles
        )

    def _draw_points(self, fragment, vertex, inputs, tiles):
        defines, uniforms, samplers = inputs
        if not self.points:
            defines = {**defines, "HAS_TRIANGLES": True}
        across, up = tiles[2] - tiles[0], tiles[3] - tiles[1]
        program = build_program(self.ctx, fragment, vertex=vertex, defines=defines)
        set_uniforms(program, {**uniforms, "u_window": (*tiles[:2], across, up)})
        bind_textures(program, {**samplers, "u_tiles": self.tiles.color[0]})
        if program not in self._arrays:
            self._arrays[program] = self.own(self.ctx.vertex_array(program, []))
        mode, vertices = (moderngl.POINTS, 1) if self.points else (moderngl.TRIANGLES, 6)
        self._arrays[program].render(mode, vertices=vertices * across * up)


def tiles_of(window) -> tuple[int, int, int, int]:
    """Return the window of a window's tiles, counted in tiles."""
    return *(n // TILE for n in window[:2]), *(-(-n // TILE) for n in window[2:])


def samples_of(tiles, size) -> tuple[int, int, int, int]:
    """Return the window of the samples that a window of tiles needs, of a grid of `size`.

    The corners and one more on each side: second differences look that far.
    """
    low, high = (max(n - 1, 0) for n in tiles[:2]), (min(n + 2, most) for n, most in zip(tiles[2:], size, strict=True))
    return *low, *high


def blending(first, in_place, canvas) -> tuple | None:
    """Return how the light of a sun comes into a picture, as `blended` wants it."""
    if not first:
        return ADDED
    return (IN_HOST if canvas.keeps_alpha else IN_PLACE) if in_place else None


def peak(view) -> tuple[float, float]:
    """Return the sine of the angle from the sun in which a peak of the sky may hide between samples, and its side.

    0 where there is none; the side is -1 for a lobe that scatters back.
    """
    tile = math.sqrt(0.5) * TILE * view.pixel_angle
    g = view.scene.atmosphere.mie_g
    lobe = 1.0 - abs(g)
    reach = LOBE_REACH * lobe if lobe < LOBE_REACH * tile else 0.0
    return min(reach, 1.0), 1.0 if g > 0.0 else -1.0


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
