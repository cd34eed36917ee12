"""Moons between the sun and the air: which of them matter, and the table of how much of the sun they leave."""

import moderngl
import numpy as np

from shadowatmo import shadow
from shadowatmo.eclipse import disc_visibility
from shadowatmo.passes.base import RenderPass

COLUMNS, ROWS = 256, 8  # separations, size ratios


def shades_the_air(atmosphere, sun, occluder) -> bool:
    """Whether an occluder's penumbra meets the sphere of the air; a sphere around the cone's nearest point decides."""
    offset = np.array(occluder.center) - sun.distance * np.array(sun.direction)
    distance = float(np.linalg.norm(offset))
    if distance <= sun.radius + occluder.radius:
        return False
    axis = offset / distance
    from_body = -np.array(occluder.center)
    z = from_body @ axis
    rho = float(np.linalg.norm(from_body - z * axis))
    cone = shadow.penumbra_cone(occluder.radius, sun.radius, distance)
    reach = atmosphere.top_radius
    return z + reach >= cone.near and rho - reach * np.hypot(1.0, cone.slope) <= cone.width(max(z, cone.near))


def shading_occluders(scene, sun) -> tuple:
    """Return the occluders of a scene whose penumbra reaches the air in the light of one sun."""
    return tuple(o for o in scene.occluders if shades_the_air(scene.atmosphere, sun, o))


def size_ratios(atmosphere, sun, occluder) -> tuple[float, float]:
    """Return the smallest and the largest ratio of the angular radii of moon and sun that can occur in the air."""
    reach, distance = atmosphere.top_radius, float(np.linalg.norm(occluder.center))
    nearest = max(distance - reach, occluder.radius)
    moon = [np.arcsin(min(occluder.radius / d, 1.0)) for d in (distance + reach, nearest)]
    disc = [np.arcsin(min(sun.radius / d, 1.0)) for d in (sun.distance - reach, sun.distance + reach)]
    return moon[0] / disc[0], max(moon[1] / disc[1], moon[0] / disc[0] * (1.0 + 1e-6))


def visibility_rows(low, high, limb_darkening) -> np.ndarray:
    """Return the visible fractions (ROWS, COLUMNS) of one moon, as eclipse.glsl looks them up."""
    k = np.linspace(low, high, ROWS)[:, None]
    nearest = np.maximum(k - 1.0, 0.0)
    delta = nearest + np.linspace(0.0, 1.0, COLUMNS) * (1.0 + k - nearest)
    return disc_visibility(k, delta, limb_darkening)


class Eclipse(RenderPass):
    """The tables of visible fractions, one for each sun; made anew when suns, moons or the air's size change."""

    name = "eclipse"
    outputs = ("visibility",)

    def __init__(self, ctx):
        super().__init__(ctx, (COLUMNS, ROWS))
        self._key, self._textures = None, {}

    def draw(self, scene, textures):
        key = (scene.suns, scene.occluders, scene.atmosphere.top_radius)
        if key != self._key:
            self.release()
            self._textures = {sun: self._table(scene, sun) for sun in scene.suns if shading_occluders(scene, sun)}
            self._key = key
        textures["visibility"] = self._textures

    def _table(self, scene, sun):
        """Return the texture of one sun: a block of rows for each moon."""
        moons = shading_occluders(scene, sun)
        rows = [visibility_rows(*size_ratios(scene.atmosphere, sun, moon), sun.limb_darkening) for moon in moons]
        data = np.concatenate(rows).astype(np.float32)
        texture = self.own(self.ctx.texture((COLUMNS, len(data)), 1, data.tobytes(), dtype="f4"))
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        return texture


def eclipse_defines(occluders) -> dict:
    """Return the features of eclipse.glsl."""
    return {
        "HAS_ECLIPSE": True,
        "OCCLUDERS": len(occluders),
        "VISIBILITY_COLUMNS": COLUMNS,
        "VISIBILITY_ROWS": ROWS,
    }


def eclipse_uniforms(scene, sun, occluders) -> dict:
    """Return the uniforms of eclipse.glsl."""
    ratios = [size_ratios(scene.atmosphere, sun, o) for o in occluders]
    return {
        "u_sun_sphere": (*(sun.distance * np.array(sun.direction)), sun.radius),
        "u_occluders": np.array([(*o.center, o.radius) for o in occluders]),
        "u_occluder_k": np.array([(low, 1.0 / (high - low)) for low, high in ratios]),
    }


def eclipse_inputs(scene, sun, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of eclipse.glsl for one sun; empty where no moon shades the air."""
    moons = shading_occluders(scene, sun)
    if not moons:
        return {}, {}, {}
    return eclipse_defines(moons), eclipse_uniforms(scene, sun, moons), {"u_visibility": textures["visibility"][sun]}


def moon_discs(view) -> np.ndarray:
    """Return (N, 4): unit vectors from the camera to the moons, and the sines of their angular radii."""
    offsets = np.array([o.center for o in view.scene.occluders]) - view.position
    distances = np.linalg.norm(offsets, axis=1)
    radii = np.array([o.radius for o in view.scene.occluders])
    return np.column_stack([offsets / np.maximum(distances, 1e-30)[:, None], np.minimum(radii / distances, 1.0)])
