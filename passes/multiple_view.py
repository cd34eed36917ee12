"""Multiple scattering of one camera in a coarse table, see multiple_view.glsl: two fetches a pixel instead of forty."""

import math

import numpy as np

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import medium_defines, medium_uniforms, segment_uniforms
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple import multiple_defines, multiple_samplers, multiple_uniforms, path_defines
from shadowatmo.passes.planet import has_relief_in_view

CELLS = {False: 16, True: 20}  # pixels, by whether the frame is interpolated between samples
FIRST = 0.375  # scale of the slices' distances in Rayleigh scale heights: uniform below, logarithmic beyond
HIGH_ALTITUDE = 2.5  # of the camera, in scale heights of the higher layer, from which the table goes by geometry
GEOMETRY_SIZES = {False: (49, 96), True: (65, 128)}  # azimuths, rows of both halves; the finer one for high cameras
SLICES = {False: 12, True: 6}  # by whether the camera is high
DUSK, DUSK_WIDTH = 0.13, 0.15  # -mu_s at which columns by the sun's height are the closest, and the width about it
SUN_SIZE = 65, 96  # of the finer one whose columns go by the sun's height
SUN_COLUMNS = 0.03  # altitude in ground radii from which columns go by the sun's height
LOWEST = 1.0  # m, altitude of the camera that the table by geometry still tells from the ground
NODES = {False: 8, True: 14}  # by whether it is the finer one
# of frames whose sum over all orders is the accurate one
ACCURATE_SIZE = (97, 192)
ACCURATE_NODES = 28


def has_whole_paths(view, textures) -> bool:
    """Return whether the table needs whole paths alone: nothing but the ground's sphere and the top ends one."""
    return "host_depth" not in textures and not has_relief_in_view(view)


def is_high(view) -> bool:
    """Return whether the camera is so high that the table goes by geometry, and not by cells of the frame."""
    atmosphere = view.scene.atmosphere
    return view.altitude > HIGH_ALTITUDE * max(atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height)


def view_defines(view, textures) -> dict:
    """Return the defines of multiple_view.glsl for the lookup."""
    return {"HAS_MULTIPLE_VIEW": True, **_kind(view, textures)}


def view_uniforms(view, sun, textures) -> dict:
    """Return the uniforms of multiple_view.glsl."""
    atmosphere = view.scene.atmosphere
    size = {"u_view_size": _size(view, textures)}
    if goes_by_cells(view, textures):
        longest = 2.0 * math.sqrt(atmosphere.top_radius**2 - atmosphere.bottom_radius**2)
        first = FIRST * atmosphere.rayleigh_scale_height
        return {**size, "u_view_slices": (first, 1.0 / math.log1p(longest / first))}
    if has_sun_columns(view):
        first, last = sun_columns(view, sun)
        top = atmosphere.thickness, 1.0, view.radius
        return {**size, "u_view_top": top, "u_view_columns": (DUSK, DUSK_WIDTH, first, last - first)}
    inside = view.altitude < atmosphere.thickness
    across = np.array(sun.direction) - (sun.direction @ view.up) * view.up
    length = float(np.linalg.norm(across))
    other = np.eye(3)[np.argmin(np.abs(view.up))]
    toward = across / length if length > 1e-6 else np.cross(view.up, other) / np.linalg.norm(np.cross(view.up, other))
    highest = min(max(view.altitude, LOWEST), atmosphere.thickness)
    return {
        **size,
        "u_view_top": (highest, 0.5 if inside else 1.0, view.radius),
        "u_view_up": view.up,
        "u_view_toward": toward,
    }


def has_sun_columns(view) -> bool:
    """Return whether columns go by the sun's height where a ray is the lowest, and not by the azimuth about the nadir.

    From far away a step of azimuth is many degrees of the sun's height, and the terminator lies across it.
    """
    atmosphere = view.scene.atmosphere
    return view.altitude > max(atmosphere.thickness, SUN_COLUMNS * atmosphere.bottom_radius)


def sun_columns(view, sun) -> tuple[float, float]:
    """Return the first and the last column, see view_column in multiple_view.glsl, for what the camera can see."""
    sine = view.scene.atmosphere.bottom_radius / view.radius
    limb = math.acos(sine)  # angle about the center between the nadir and the horizon
    zenith = math.acos(min(max(float(sun.direction @ view.up), -1.0), 1.0))
    ends = np.cos([min(zenith + limb, math.pi), max(zenith - limb, 0.0)])
    return tuple(np.arcsinh((ends + DUSK) / DUSK_WIDTH))


def goes_by_cells(view, textures) -> bool:
    """Return whether the table goes by cells of the frame, and then has what moons leave in it, but for shade()."""
    return not (is_high(view) or has_whole_paths(view, textures))


def _kind(view, textures):
    columns = {"HAS_SUN_COLUMNS": True} if has_sun_columns(view) else {}
    if has_whole_paths(view, textures):
        return {"SLICES": 1, "HAS_HIGH_CAMERA": True, "HAS_WHOLE_PATHS": True, **columns}
    if is_high(view):
        return {"SLICES": SLICES[True], "HAS_HIGH_CAMERA": True, **columns}
    return {"SLICES": SLICES[False], "CELL": _cell(view)}


def _cell(view):
    return CELLS[view.quality.tolerance > 0.0]


def _is_fine(view, textures):
    """Return whether a high camera's table has all its texels: not where slices must be paid between samples."""
    return is_high(view) and (view.quality.tolerance == 0.0 or has_whole_paths(view, textures))


def _is_accurate(view):
    return view.quality.multiple != "balanced"


def _size(view, textures):
    if goes_by_cells(view, textures):
        return tuple(-(-n // _cell(view)) + 1 for n in view.size)
    if _is_accurate(view):
        return ACCURATE_SIZE
    fine = _is_fine(view, textures)
    return SUN_SIZE if fine and has_sun_columns(view) else GEOMETRY_SIZES[fine]


class MultipleView(RenderPass):
    """Source over extinction of multiple scattering, averaged along the paths from the camera, for one sun."""

    name = "multiple_view"
    inputs = ("multiple_table", "multiple_level", "ground_irradiance", "aureole_table")
    outputs = ("multiple_view",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self._targets = {}

    def draw(self, view, textures, sun, recipe):
        atmosphere, geometry = view.scene.atmosphere, not goes_by_cells(view, textures)
        kind, (width, height) = _kind(view, textures), _size(view, textures)
        size = width, height * kind["SLICES"]
        if size not in self._targets:
            target = self.own(Target(self.ctx, size, color=("rgba32f",)))
            target.color[0].filter = (self.ctx.LINEAR, self.ctx.LINEAR)
            self._targets[size] = target
        nodes = ACCURATE_NODES if _is_accurate(view) else NODES[_is_fine(view, textures)]
        defines = {**medium_defines(atmosphere), **multiple_defines(recipe), **path_defines(nodes, 2)}
        uniforms = {**view.camera_uniforms(), **medium_uniforms(atmosphere), **segment_uniforms(atmosphere)}
        uniforms |= {**multiple_uniforms(atmosphere), **view_uniforms(view, sun, textures), **view.axis_uniforms(sun)}
        defines |= {"TERMS": view.quality.terms, **kind}
        if view.is_far and not geometry:
            defines["HAS_FAR_CAMERA"] = True
        elif view.is_far:
            uniforms.pop("u_moments")
        samplers = multiple_samplers(textures)
        if goes_by_cells(view, textures) and "eclipse_view" in textures:
            moons = textures["eclipse_view"]
            defines, uniforms, samplers = defines | moons[0], uniforms | moons[1], samplers | moons[2]
        self._targets[size].framebuffer.use()
        self.fullscreen("multiple_view.frag", defines, uniforms, samplers)
        textures["multiple_view"] = self._targets[size].color[0]

    def release(self):
        super().release()
        self._targets.clear()
