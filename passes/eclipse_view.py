"""Multiple scattering under moons for one camera: a coarse table of ratios, see eclipse_view.glsl."""

import math

import numpy as np

from shadowatmo.eclipse_multiple import RATIO_RECIPES, SHADE
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import medium_defines, medium_uniforms, segment_uniforms
from shadowatmo.passes.eclipse_multiple import ratio_inputs
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple import OUTPUTS, multiple_defines, multiple_samplers, multiple_uniforms, path_defines
from shadowatmo.passes.multiple_view import is_high

CELLS = {"balanced": (25, 15), "accurate": (81, 46)}  # corners of cells across and up
SLICES = {("balanced", False): 6, ("balanced", True): 3, ("accurate", False): 8, ("accurate", True): 6}  # high camera
NODES = {"balanced": 6, "accurate": 12}
TERMS = 4  # degree of the source's harmonics
FIRST = 0.375  # scale of the slices' distances in Rayleigh scale heights: uniform below, logarithmic beyond
RIM = 128  # points of the air's rim that are looked for in the frame


def _kind(view, textures):
    high = is_high(view)
    if high and not {"planet_depth", "host_depth"} & set(textures):  # nothing but the ground's sphere ends a path
        return {"CELL_SLICES": 1, "HAS_HIGH_CELLS": True, "HAS_ONE_SLICE": True}
    return {"CELL_SLICES": SLICES[view.quality.multiple, high], **({"HAS_HIGH_CELLS": True} if high else {})}


def eclipse_view_uniforms(view) -> dict:
    """Return the uniforms of eclipse_view.glsl."""
    atmosphere, size = view.scene.atmosphere, np.array(CELLS[view.quality.multiple])
    longest = 2.0 * math.sqrt(atmosphere.top_radius**2 - atmosphere.bottom_radius**2)
    first = FIRST * atmosphere.rayleigh_scale_height
    low, high = air_rectangle(view)
    scale = (size - 1) / (high - low)
    return {
        "u_cells": (*scale, *(0.5 - low * scale)),
        "u_cells_size": size,
        "u_cell_slices": (first, 1.0 / math.log1p(longest / first)),
    }


def air_rectangle(view) -> np.ndarray:
    """Return the lower and the upper corner [pixels] of the part of a frame that can show air, (2, 2)."""
    frame = np.array([(0.0, 0.0), view.size])
    sine = view.scene.atmosphere.top_radius / view.radius
    if sine >= 0.999:
        return frame
    turns = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)
    east = np.cross(view.up, np.eye(3)[np.argmin(np.abs(view.up))])
    east /= np.linalg.norm(east)
    ring = np.outer(np.cos(turns), east) + np.outer(np.sin(turns), np.cross(view.up, east))
    x, y, _, depth = view.to_clip[:, :3] @ (sine * ring - math.sqrt(1.0 - sine * sine) * view.up).T
    if depth.min() < 0.05 * depth.max() or depth.max() <= 0.0:
        return frame
    rim = 0.5 * (np.stack([x, y], axis=1) / depth[:, None] + 1.0) * view.size
    margin = 0.01 * (rim.max(axis=0) - rim.min(axis=0))
    low, high = (np.clip(c, 0.0, view.size) for c in (rim.min(axis=0) - margin, rim.max(axis=0) + margin))
    return np.stack([low, high]) if np.all(high > low) else frame


class EclipseView(RenderPass):
    """What moons leave of multiple scattering along the paths from the camera, for one sun.

    Its output is defines, uniforms and samplers of eclipse_view.glsl for the lookup.
    """

    name = "eclipse_view"
    inputs = ("ratio", "visibility", *OUTPUTS)
    outputs = ("eclipse_view",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self._targets = {}

    def draw(self, view, textures, sun):
        textures.pop("eclipse_view", None)  # of another sun
        atmosphere, effort = view.scene.atmosphere, view.quality.multiple
        ratio = ratio_inputs(view.scene, sun, textures, RATIO_RECIPES[effort], TERMS)
        if not ratio[0]:
            return
        kind = _kind(view, textures)
        slices = kind["CELL_SLICES"]
        if slices not in self._targets:
            width, height = CELLS[effort]
            self._targets[slices] = self.own(Target(self.ctx, (width, height * slices), color=("rgba16f",)))
            self._targets[slices].color[0].filter = (self.ctx.LINEAR, self.ctx.LINEAR)
        count = NODES[effort]
        defines = {**ratio[0], **medium_defines(atmosphere), **multiple_defines(RECIPES[effort])}
        defines |= {**path_defines(count, 2), **kind, "TERMS": 4}
        defines |= {"HAS_FAR_CAMERA": True} if view.is_far else {}
        del defines["HAS_RATIO"]
        uniforms = {**ratio[1], **view.camera_uniforms(), **medium_uniforms(atmosphere), **segment_uniforms(atmosphere)}
        uniforms |= {**multiple_uniforms(atmosphere), **eclipse_view_uniforms(view), **view.axis_uniforms(sun)}
        uniforms |= {"u_camera_position": view.position, "u_node_count": count}
        self._targets[slices].framebuffer.use()
        self.fullscreen("eclipse_view.frag", defines, uniforms, {**ratio[2], **multiple_samplers(textures)})
        lookup = {"HAS_ECLIPSE_VIEW": True, "RATIO_SHADE": SHADE, **kind}
        samplers = {"u_eclipse_view": self._targets[slices].color[0]}
        textures["eclipse_view"] = lookup, eclipse_view_uniforms(view), samplers

    def release(self):
        super().release()
        self._targets.clear()
