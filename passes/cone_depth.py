"""Umbra, antumbra and penumbra of the moons as depths: where each pixel's ray enters and leaves them.

The shading does not read them (a table of the visible fraction tells more), so they are drawn when somebody asks. They
are solved per pixel, as the planet's own shadow is; no proxy is needed where every pixel of the picture is wanted.
"""

from dataclasses import dataclass

import moderngl
import numpy as np

from shadowatmo import shadow
from shadowatmo.parameters import Occluder
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import cone_uniforms
from shadowatmo.passes.eclipse import shading_occluders
from shadowatmo.passes.gl.textures import Target


@dataclass(frozen=True, eq=False)
class ConeDepths:
    """The cones of one occluder in the light of one sun.

    Parameters
    ----------
    occluder : Occluder
        Whose shadow it is.
    outer : moderngl.Texture
        Two 32-bit float channels: where the ray enters the outer cone and where it leaves it, distances from the camera
        [m]; 0 and 0 where it does not, 0 first for a camera inside. The penumbra is what of it lies in no other cone.
        From far away they have a float's digits of the camera's distance: 64 m at 1e9 m.
    umbra, antumbra : moderngl.Texture or None
        The same; None for a cone that ends before the air, or begins behind it.
    """

    occluder: Occluder
    outer: moderngl.Texture
    umbra: moderngl.Texture | None
    antumbra: moderngl.Texture | None


class ConeDepth(RenderPass):
    """Front and back of every cone whose penumbra reaches the air, one attachment for a cone."""

    name = "cone_depth"
    outputs = ("cone_depths",)

    def draw(self, view, textures, sun):
        self.release()
        moons = shading_occluders(view.scene, sun)
        textures["cone_depths"] = tuple(self._moon(view, sun, moon) for moon in moons)

    def _moon(self, view, sun, moon):
        reached = reaching_cones(view.scene.atmosphere, sun, moon)
        target = self.own(Target(self.ctx, self.size, color=("rg32f",) * len(reached)))
        axis, _ = cone_axis(sun, moon)
        along = float(-np.array(moon.center) @ axis)  # m, from the moon to the point nearest to the planet's center
        defines = {"HAS_FAR_CAMERA": True} if view.is_far else {}
        uniforms = {
            **view.camera_uniforms(),
            "u_cone_axis.direction": axis,
            "u_cone_axis.off": np.cross(view.position, axis),
            "u_cone_axis.z": view.position @ axis,
            "u_cone_aside": np.cross(moon.center, axis),
        }
        for layer, (name, cone) in enumerate(reached.items()):
            uniforms |= cone_uniforms(f"u_{name}", cone.moved(along))
            if name != "outer":
                defines |= {f"HAS_{name.upper()}": True, f"{name.upper()}_LAYER": layer}
        target.framebuffer.use()
        self.fullscreen("cone_depth.frag", defines, uniforms)
        layers = dict(zip(reached, target.color, strict=True))
        return ConeDepths(moon, layers["outer"], layers.get("umbra"), layers.get("antumbra"))


def cone_axis(sun, moon) -> tuple[np.ndarray, float]:
    """Return the unit vector (3,) from a sun to a moon, and their distance [m]."""
    offset = np.array(moon.center) - sun.distance * np.array(sun.direction)
    distance = float(np.linalg.norm(offset))
    return offset / distance, distance


def reaching_cones(atmosphere, sun, moon) -> dict:
    """Return by name the cones of a moon that may meet the sphere of the air: "outer" always, "umbra", "antumbra"."""
    axis, distance = cone_axis(sun, moon)
    umbra = shadow.umbra_cone(moon.radius, sun.radius, distance)
    cones = {"outer": shadow.penumbra_cone(moon.radius, sun.radius, distance)}
    reach, from_moon = atmosphere.top_radius, -np.array(moon.center)
    z = from_moon @ axis
    aside = float(np.linalg.norm(from_moon - z * axis)) - reach
    if z + reach >= umbra.near and z - reach <= umbra.far and aside <= umbra.width(max(z - reach, umbra.near)):
        cones["umbra"] = umbra
    if umbra.far < shadow.FAR_AWAY and z + reach >= umbra.far and aside <= -umbra.width(z + reach):
        cones["antumbra"] = shadow.antumbra_cone(moon.radius, sun.radius, distance)
    return cones
