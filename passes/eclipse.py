"""Moons between the sun and the air: which of them matter, and the tables of how much of the sun they leave."""

import moderngl
import numpy as np

from shadowatmo import shadow
from shadowatmo.eclipse import disc_visibility
from shadowatmo.moon_shadows import overlap_box, shadow_path, sorted_by_width, sun_axes
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import glsl_array
from shadowatmo.passes.gl.textures import Target
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.ring import chord_polynomial, dims_the_air

COLUMNS = 256  # separations
NARROW_ROWS, WIDE_ROWS = 8, 48  # size ratios
OVERLAP_TEXELS, SHARP_TEXELS, OVERLAP_LAYERS = 160, 320, 12  # of a map across the sun's direction and along it
ARC_NODES = 10  # on every free stretch of a moon's edge; 8 leave an error of 8e-4
MAX_DISCS = 8  # that one map takes together


def tabled_occluders(scene, sun) -> tuple:
    """Return the same in the order in which visibility.glsl counts them: narrow ones first."""
    narrow, wide = sorted_by_width(scene.atmosphere, sun, shading_occluders(scene, sun))
    return (*narrow, *wide)


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


def dimming_rings(scene, sun) -> tuple:
    """Return the rings of a scene whose shadow in the light of one sun may reach the air."""
    return tuple(ring for ring in scene.rings if dims_the_air(scene.atmosphere, sun, ring))


def is_shaded(scene, sun) -> bool:
    """Whether anything shades the air of a scene in the light of one sun."""
    return bool(shading_occluders(scene, sun) or dimming_rings(scene, sun))


def size_ratios(atmosphere, sun, occluder) -> tuple[float, float]:
    """Return the smallest and the largest ratio of the angular radii of moon and sun that can occur in the air."""
    reach, distance = atmosphere.top_radius, float(np.linalg.norm(occluder.center))
    nearest = max(distance - reach, occluder.radius)
    moon = [np.arcsin(min(occluder.radius / d, 1.0)) for d in (distance + reach, nearest)]
    disc = [np.arcsin(min(sun.radius / d, 1.0)) for d in (sun.distance - reach, sun.distance + reach)]
    return moon[0] / disc[0], max(moon[1] / disc[1], moon[0] / disc[0] * (1.0 + 1e-6))


def visibility_rows(k, limb_darkening) -> np.ndarray:
    """Return the visible fractions (n, COLUMNS) of one moon over its ratios k (n,), as visibility.glsl finds them."""
    k = k[:, None]
    nearest = np.maximum(k - 1.0, 0.0)
    delta = nearest + np.linspace(0.0, 1.0, COLUMNS) * (1.0 + k - nearest)
    return disc_visibility(k, delta, limb_darkening)


def bilinear_cells(rows) -> np.ndarray:
    """Return a + b x + z (c + d x) of every cell of a table (n, m) as (n, m, 4): the last row and column go on evenly.

    One exact fetch of four numbers costs a renderer on the CPU half of what a filtered one of a single number does.
    """
    padded = np.pad(rows, ((0, 1), (0, 1)), mode="edge")
    corner = padded[:-1, :-1]
    across, down = padded[:-1, 1:] - corner, padded[1:, :-1] - corner
    return np.stack([corner, across, down, padded[1:, 1:] - corner - across - down], axis=-1)


def wide_rows(low, high) -> tuple[np.ndarray, tuple]:
    """Return ratios k (WIDE_ROWS,) from `low` to `high`, and the four numbers that give the row of a ratio.

    The fraction has a kink at k = 1, where the first total eclipses are, so that one row lies there; further on it
    depends on 1/k.
    """
    low, high = float(low), float(high)
    below = 0 if low >= 1.0 else WIDE_ROWS - 1 if high <= 1.0 else WIDE_ROWS // 3
    turn = min(max(low, 1.0), high)
    k = np.linspace(low, turn, below + 1)
    rise = below / (turn - low) if below else 0.0
    above = WIDE_ROWS - 1 - below
    if not above:
        return k, (-low * rise, rise, float(below), 0.0)
    fall = above / (1.0 / turn - 1.0 / high)
    further = 1.0 / (1.0 / turn - np.arange(1, above + 1) / fall)
    return np.concatenate([k, further]), (-low * rise, rise, below + fall / turn, fall)


class Eclipse(RenderPass):
    """The tables of visible fractions, one for each sun; made anew when suns, moons or the air's size change."""

    name = "eclipse"
    outputs = ("visibility",)

    def __init__(self, ctx):
        super().__init__(ctx, (COLUMNS, NARROW_ROWS))
        self._key, self._textures = None, {}

    def draw(self, scene, textures):
        key = (scene.suns, scene.occluders, scene.rings, scene.atmosphere.top_radius)
        if key != self._key:
            self.release()
            self._textures = {sun: self._tables(scene, sun) for sun in scene.suns if is_shaded(scene, sun)}
            self._key = key
        textures["visibility"] = self._textures

    def _tables(self, scene, sun):
        """Return defines, uniforms and samplers of one sun: rows for each moon, a map of their overlaps if any."""
        moons = EclipseMoons(scene, sun)
        samplers = {"u_visibility": self._visibility(moons)} if len(moons) else {}
        if moons.box is not None:
            samplers["u_overlaps"] = self._overlaps(moons)
        return moons.defines(), moons.uniforms(), samplers

    def _visibility(self, moons):
        rows = [bilinear_cells(visibility_rows(k, moons.sun.limb_darkening)) for k in moons.ratios()]
        data = np.concatenate(rows).astype(np.float32)
        return self.own(self.ctx.texture(data.shape[1::-1], 4, data.tobytes(), dtype="f4"))

    def _overlaps(self, moons):
        target = self.own(Target(self.ctx, (moons.texels, moons.texels * OVERLAP_LAYERS), color=("r32f",)))
        target.framebuffer.use()
        texels = np.array([moons.texels, moons.texels, OVERLAP_LAYERS])
        defines = {name: value for name, value in moons.defines().items() if name != "HAS_OVERLAPS"}
        uniforms = {
            **moons.uniforms(),
            **joint_uniforms(moons.sun, len(moons)),
            "u_box_low": moons.box[0],
            "u_box_step": (moons.box[1] - moons.box[0]) / (texels - 1),
        }
        uniforms = {name: value for name, value in uniforms.items() if name not in ("u_overlap_low", "u_overlap_scale")}
        del defines["HAS_ECLIPSE"]
        defines |= {**joint_defines(), "OVERLAP_TEXELS": moons.texels}
        self.fullscreen("overlap.frag", defines, uniforms)
        texture = target.color[0]
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        return texture


class EclipseMoons:
    """What shades the air in the light of one sun, as visibility.glsl takes it: narrow moons, wide ones, rings."""

    def __init__(self, scene, sun):
        self.atmosphere, self.sun = scene.atmosphere, sun
        shading = shading_occluders(scene, sun)
        self.narrow, self.wide = sorted_by_width(scene.atmosphere, sun, shading)
        self.texels = SHARP_TEXELS if self.wide else OVERLAP_TEXELS  # a near moon has a sharp edge
        self.rings = dimming_rings(scene, sun)
        self.box = overlap_box(scene.atmosphere, sun, shading) if 1 < len(shading) <= MAX_DISCS else None

    def __len__(self):
        return len(self.narrow) + len(self.wide)

    def ratios(self):
        """Yield the ratios k (n,) of each moon's rows: over heights of the air, or by `wide_rows`."""
        reach, sun = self.atmosphere.top_radius, self.sun
        heights = np.linspace(-reach, reach, NARROW_ROWS)
        for moon in self.narrow:
            path = shadow_path(sun, moon)
            yield (path.size[0] + heights * path.size[1]) / (path.blur[0] + heights * path.blur[1])
        for moon in self.wide:
            yield wide_rows(*size_ratios(self.atmosphere, sun, moon))[0]

    def defines(self) -> dict:
        """Return the features of visibility.glsl."""
        defines = {"HAS_ECLIPSE": True}
        if len(self):
            rows = NARROW_ROWS * len(self.narrow) + WIDE_ROWS * len(self.wide)
            defines |= {"HAS_MOON_TABLES": True, "VISIBILITY_COLUMNS": COLUMNS - 1, "VISIBILITY_ROWS": rows}
        if self.narrow:
            defines |= {"HAS_NARROW_MOONS": True, "NARROW_MOONS": len(self.narrow), "NARROW_ROWS": NARROW_ROWS}
        if self.wide:
            defines |= {"HAS_WIDE_MOONS": True, "WIDE_MOONS": len(self.wide), "WIDE_ROWS": WIDE_ROWS}
        if self.rings:
            defines |= {"HAS_RINGS": True, "RINGS": len(self.rings)}
        if self.box is not None:
            defines |= {"HAS_OVERLAPS": True, "OVERLAP_TEXELS": self.texels, "OVERLAP_LAYERS": OVERLAP_LAYERS}
        return defines

    def uniforms(self) -> dict:
        """Return the uniforms of visibility.glsl."""
        sun, reach, axes = self.sun, self.atmosphere.top_radius, sun_axes(self.sun)
        uniforms = {"u_sun_axes": axes}
        if self.narrow:
            paths = [shadow_path(sun, moon) for moon in self.narrow]
            uniforms["u_moon_path"] = np.array([path.center.T.ravel() for path in paths])
            uniforms["u_moon_width"] = np.array([(*path.blur, *path.size) for path in paths])
            uniforms["u_moon_rows"] = (-reach, 0.5 * (NARROW_ROWS - 1) / reach)
        if self.wide:
            ratios = [size_ratios(self.atmosphere, sun, moon) for moon in self.wide]
            uniforms["u_sun_sphere"] = (0.0, 0.0, sun.distance, sun.radius)
            uniforms["u_wide_moons"] = np.array([(*(np.array(m.center) @ axes), m.radius) for m in self.wide])
            uniforms["u_wide_rows"] = np.array([wide_rows(*ratio)[1] for ratio in ratios])
        if self.rings:
            uniforms |= ring_uniforms(sun, self.rings)
        if self.box is not None:
            uniforms["u_overlap_low"] = self.box[0]
            uniforms["u_overlap_scale"] = 1.0 / (self.box[1] - self.box[0])
        return uniforms


def ring_uniforms(sun, rings) -> dict:
    """Return the uniforms of visibility.glsl for rings."""
    axes = sun_axes(sun)
    return {
        "u_ring_planes": np.array([(*(np.array(r.normal) @ axes), np.dot(r.normal, r.center)) for r in rings]),
        "u_ring_centers": np.array([np.array(r.center) @ axes for r in rings]),
        "u_ring_edges": np.array([(r.inner_radius, r.outer_radius, 1.0 - r.transmission(sun)) for r in rings]),
        "u_chord": chord_polynomial(sun.limb_darkening),
        "u_ring_sun": (sun.distance, sun.radius),
    }


def joint_defines() -> dict:
    """Return the constants of joint.glsl: nodes that gather at both ends of a stretch, at the 3/2 powers there."""
    nodes, weights = gauss_legendre(ARC_NODES)
    turn = 0.5 * np.pi * nodes
    return {
        "MAX_DISCS": MAX_DISCS,
        "ARC_NODE_COUNT": ARC_NODES,
        "ARC_NODE_VALUES": glsl_array(np.sin(turn) ** 2),
        "ARC_WEIGHT_VALUES": glsl_array(weights * np.pi * np.sin(turn) * np.cos(turn)),
    }


def joint_uniforms(sun, count) -> dict:
    """Return the uniforms of joint.glsl."""
    return {"u_limb_darkening": sun.limb_darkening, "u_disc_count": count}


def eclipse_inputs(sun, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of visibility.glsl for one sun; empty where nothing shades the air."""
    return textures.get("visibility", {}).get(sun, ({}, {}, {}))


def moon_discs(view) -> np.ndarray:
    """Return (N, 4): unit vectors from the camera to the moons, and the sines of their angular radii."""
    offsets = np.array([o.center for o in view.scene.occluders]) - view.position
    distances = np.linalg.norm(offsets, axis=1)
    radii = np.array([o.radius for o in view.scene.occluders])
    return np.column_stack([offsets / np.maximum(distances, 1e-30)[:, None], np.minimum(radii / distances, 1.0)])
