"""Pass 5, second half: the composite. Each class of pixels has a shader of its own, without branches over pieces.

The widths pass wrote the class of every pixel as a depth. Drawing one triangle per class with the depth test on
equality shades exactly the pixels of that class: hardware and software rasterizers alike reject the others early.
"""

import math
from dataclasses import replace

from shadowatmo.eclipse_multiple import SHADE
from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.canvas import ADDED, Canvas, blended, drawing_in
from shadowatmo.passes.constants import (
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    transmittance_defines,
)
from shadowatmo.passes.eclipse import eclipse_inputs, moon_discs
from shadowatmo.passes.march import march_method
from shadowatmo.passes.multiple import multiple_uniforms
from shadowatmo.passes.multiple_view import goes_by_cells, view_defines, view_uniforms
from shadowatmo.passes.table3d import table3d_method
from shadowatmo.passes.table4d import table4d_method
from shadowatmo.passes.table4d_view import VIEW_TEXTURES
from shadowatmo.passes.table_build import inscatter_samplers
from shadowatmo.passes.table_probe import TABLE_METHODS
from shadowatmo.passes.terminator import terminator_inputs
from shadowatmo.passes.transmittance import table_samplers
from shadowatmo.passes.widths import cuts_inputs, has_long_paths
from shadowatmo.quality import PATH_METHODS
from shadowatmo.screen import frame_around

# by class: no air, one lit piece, one lit piece and a shadow, a shadow between two lit pieces
CLASS_FEATURES = (
    {},
    {"HAS_AIR": True},
    {"HAS_AIR": True, "HAS_SHADOW": True},
    {"HAS_AIR": True, "HAS_SHADOW": True, "HAS_TWO_PIECES": True},
)
LIMB_GAP_NODES = 8  # of a shadow that may lie about the tangent point; what is behind it was 23 % off by 4
NOTHING = {}, {}, {}  # defines, uniforms and samplers
HIGH_SUN_CLASS = {"HAS_AIR": True}  # one lit piece again, in the light of a finite disc that may be taken for a point
WIDTHS_OPACITY = 0.6  # of a unit of brightness, for the method "widths"


class AtmosphereComposite(RenderPass):
    """Dims the scene by the air before it and adds the light that the air scatters, one sun after the other."""

    name = "atmosphere"
    inputs = ("cuts", "class")
    outputs = ("color",)
    blends = False  # every pixel of the window is written: classes are drawn by a depth test, also that without air

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self.canvas = None

    def draw(self, view, textures, sun, first):
        if self.canvas is None:
            self.canvas = self.own(Canvas(self.ctx, self.size, textures["class"]))
        window, disc = view.windows(sun)
        inputs = composite_inputs(view, textures, sun, first)
        if first:
            prepare(self, self.canvas, window, inputs[0][2].get("u_background"))
        self.canvas.mark(window, disc)
        if window is not None:
            with blended(self.ctx, None if first else ADDED), drawing_in(self.canvas.framebuffer, window):
                self._draw_classes(view, textures, sun, inputs)
        if disc is not None:
            draw_disc(self, self.canvas, disc, inputs[0], cuts_inputs(view, textures, sun))
        textures["color"] = self.canvas.color

    def _draw_classes(self, view, textures, sun, inputs):
        seen, air, class_features = inputs
        seen = joined(seen, ({}, {}, {"u_cuts": textures["cuts"]}))
        if view.has_terminator(sun):
            class_features = (*class_features, HIGH_SUN_CLASS)
        with depth_test(self.ctx, "=="):
            for number, features in enumerate(class_features):
                if number == 0 and view.is_inside:
                    continue  # every ray meets the air
                disc = NOTHING if features is HIGH_SUN_CLASS else terminator_inputs(view, sun, textures)
                own = features, {"u_class": number}, {}
                inputs = joined(seen, air, disc, own) if features else joined(seen, own)
                self.fullscreen("atmosphere.frag", *inputs, vertex="class.vert")


def prepare(render_pass, canvas, window, background):
    """Write what a picture of our own has around a window that will be written whole: a background, or nothing."""
    if background is None:
        canvas.clear(kept=window)
        return
    for part in frame_around(window, canvas.size):
        with drawing_in(canvas.framebuffer, part):
            render_pass.fullscreen("copy.frag", {"HAS_NO_ALPHA": True}, {}, {"u_color": background})
    canvas.mark((0, 0, *canvas.size))


def draw_disc(render_pass, canvas, window, seen, cuts):
    """Add a sun's disc where no air stands before it: `seen` as composite_inputs has it, `cuts` as cuts_inputs."""
    own = {"HAS_SOLVED_CUTS": True}, {}, {}
    with blended(render_pass.ctx, ADDED), drawing_in(canvas.framebuffer, window):
        render_pass.fullscreen("atmosphere.frag", *joined((without_background(seen), seen[1], {}), cuts, own))


def without_background(inputs) -> dict:
    """Return the defines of inputs without that of a background, be it read or blended."""
    return {name: value for name, value in inputs[0].items() if name not in ("HAS_BACKGROUND", "HAS_IN_PLACE")}


def joined(*inputs) -> tuple[dict, dict, dict]:
    """Join several triples of defines, uniforms and samplers."""
    return tuple({name: value for part in kind for name, value in part.items()} for kind in zip(*inputs, strict=True))


def composite_inputs(view, textures, sun, first) -> tuple[tuple, tuple, tuple]:
    """Return what atmosphere.frag needs for one sun; the background comes in with the first one that is drawn.

    Returns
    -------
    seen, air : (dict, dict, dict)
        Defines, uniforms and samplers of what stands behind the air, and in addition of the air.
    class_features : tuple of dict
        Defines that select the shader of each class of pixels.
    """
    defines = {"HAS_FAR_CAMERA": True} if view.is_far else {}
    uniforms = {**view.camera_uniforms(), **view.axis_uniforms(sun), "u_irradiance": sun.irradiance}
    samplers = {}
    if first and "background" in textures:
        defines["HAS_BACKGROUND"] = True
        samplers["u_background"] = textures["background"]
    if view.scene.sun_disc:
        defines["HAS_SUN_DISC"] = True
        uniforms |= sun_disc_uniforms(view, sun)
        if view.scene.occluders:
            defines |= {"HAS_MOONS": True, "MOONS": len(view.scene.occluders)}
            uniforms["u_moons"] = moon_discs(view)
    method = view.quality.method
    if method in TABLE_METHODS and "inscatter" not in textures:
        method = "segments"  # until the table is ready
    method_defines, method_uniforms, class_features = METHODS[method](view)
    method_samplers = table_samplers(method_uniforms, textures)
    if method in TABLE_METHODS:
        method_samplers |= inscatter_samplers(textures)
    if "view_inscatter" in textures:
        method_defines = {**method_defines, "HAS_TABLE4D_VIEW": True}
        method_samplers |= {f"u_{name}": textures[name] for name in VIEW_TEXTURES}
    air = method_defines, method_uniforms, method_samplers
    moons = eclipse_inputs(sun, textures) if method != "widths" else NOTHING
    if moons[0]:
        if method in TABLE_METHODS:
            air = joined(air, ({"HAS_TABLE_ECLIPSE": True}, {}, {}))
        air = joined(air, moons, ({}, {"u_camera_position": view.position}, {}))
    if "multiple_view" in textures and view.quality.method in PATH_METHODS:
        more = {**multiple_uniforms(view.scene.atmosphere), **view_uniforms(view, sun, textures)}
        air = joined(air, (view_defines(view, textures), more, {"u_multiple_view": textures["multiple_view"]}))
        if moons[0] and "eclipse_view" in textures:
            air = joined(air, ({"HAS_SHADE": True, "RATIO_SHADE": SHADE}, {}, {}))
            if not goes_by_cells(view, textures):
                air = joined(air, textures["eclipse_view"])
    return (defines, uniforms, samplers), air, class_features


def sun_disc_uniforms(view, sun) -> dict:
    """Return the uniforms of sun_disc.glsl: the disc's mean radiance is the irradiance over its solid angle."""
    toward, sine = view.sun_seen(sun)
    center = 1.0 / (math.pi * sine * sine * (1.0 - sun.limb_darkening / 3.0))
    return {
        "u_sun_disc": (sine, sun.limb_darkening, center),
        "u_sun_toward": toward,
        "u_pixel_angle": view.pixel_angle,
    }


def segments_method(view):
    """Return defines, uniforms and the features of each class of pixels for the method "segments"."""
    atmosphere, quality = view.scene.atmosphere, view.quality
    defines = {"HAS_SEGMENTS": True, **medium_defines(atmosphere)}
    defines |= {**transmittance_defines(atmosphere, quality), **segment_defines(quality, atmosphere)}
    features = limb_features(view) if has_long_paths(view) else CLASS_FEATURES
    return defines, {**medium_uniforms(atmosphere), **segment_uniforms(atmosphere)}, features


def limb_features(view) -> tuple[dict, ...]:
    """Return the features of the classes of pixels where they show the limb: the longest paths, lit and shadowed."""
    quality = replace(view.quality, gap_nodes=max(view.quality.gap_nodes, LIMB_GAP_NODES))
    more = segment_defines(quality, view.scene.atmosphere)
    nothing, lit, one_piece, two_pieces = CLASS_FEATURES
    return nothing, lit, {**one_piece, **more}, {**two_pieces, **more, "HAS_LONG_PATHS": True}


def widths_method(view):
    """Return the same for the method "widths", whose one formula serves every pixel of air.

    A brightness of 1, white on the published display, is that of a white wall in the sun.
    """
    nearest, farthest = view.air_range
    uniforms = {"u_air_color": published_color(view.scene.atmosphere), "u_range": farthest - nearest}
    return {"HAS_WIDTHS": True}, uniforms, ({}, *[{"HAS_AIR": True}] * (len(CLASS_FEATURES) - 1))


def published_color(atmosphere) -> tuple[float, float, float, float]:
    """Return color and opacity of a unit of brightness for the method "widths"."""
    blue = max(atmosphere.rayleigh_scattering) or 1.0
    return *(math.sqrt(c / blue) / math.pi for c in atmosphere.rayleigh_scattering), WIDTHS_OPACITY


METHODS = {
    "march": march_method,
    "segments": segments_method,
    "table3d": table3d_method,
    "table3d-multiple": table3d_method,
    "table4d": table4d_method,
    "widths": widths_method,
}
