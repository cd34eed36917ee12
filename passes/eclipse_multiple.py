"""Light scattered more than once under moons: solves the volumes of eclipse_multiple.glsl when the geometry changes.

The shaders gather radiance with and without a moon at the nodes of its volume; moments and ratios of so few nodes are
worked out in float64 by the twin (shadowatmo/eclipse_multiple.py), which reads them back between two gathers.
"""

import math

import numpy as np

from shadowatmo import harmonics
from shadowatmo.eclipse_multiple import RATIO_RECIPES, SHADE, RatioGrid, shadow_frame
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import (
    cone_uniforms,
    glsl_array,
    medium_defines,
    medium_uniforms,
    segment_uniforms,
    shadow_cone,
    transmittance_defines,
)
from shadowatmo.passes.eclipse import eclipse_inputs, tabled_occluders
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple import OUTPUTS, multiple_defines, multiple_samplers, multiple_uniforms, path_defines
from shadowatmo.quality import Quality


def ratio_defines(recipe, moons, terms=None) -> dict:
    """Return the defines of eclipse_multiple.glsl; terms: degree of the harmonics that a lookup sums, if not all."""
    sizes = {"RINGS": recipe.rings, "SECTORS": recipe.sectors, "HEIGHTS": recipe.heights, "DEGREE": recipe.degree}
    defines = {f"RATIO_{name}": value for name, value in sizes.items()}
    defines["OCCLUDERS"] = moons
    defines["RATIO_TERMS"] = recipe.degree if terms is None else terms
    defines["RATIO_SHADE"] = SHADE
    defines["RATIO_NORM_VALUES"] = glsl_array(
        [
            math.sqrt((2 * l + 1) / (4 * math.pi) * math.factorial(l - m) / math.factorial(l + m) * (2 if m else 1))
            for l, m in zip(*harmonics.harmonic_indices(recipe.degree), strict=True)  # noqa: E741
        ]
    )
    return {**defines, "HAS_MOON_SUM": True} if moons > 1 else defines


def ratio_uniforms(scene, sun, recipe) -> dict:
    """Return the uniforms of eclipse_multiple.glsl for one sun."""
    frames = [shadow_frame(scene.atmosphere, sun, moon) for moon in tabled_occluders(scene, sun)]
    rings = [(f.edge, 1.0 / f.width, f.rings[0], 1.0 / (f.rings[1] - f.rings[0])) for f in frames]
    return {
        "u_ratio_axes": np.array([f.axes for f in frames]),
        "u_ratio_rings": np.array(rings),
        "u_ratio_squeeze": np.array([f.squeeze for f in frames]),
        "u_ratio_moments": harmonics.phase_moments(scene.atmosphere.mie_g, recipe.degree),
    }


def ratio_inputs(scene, sun, textures, recipe, terms=None) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of eclipse_multiple.glsl for one sun, those of eclipse.glsl included.

    Empty where no moon shades the air, or while there is no table of multiple scattering.
    """
    texture = textures.get("ratio", {}).get(sun)
    if texture is None:
        return {}, {}, {}
    defines, uniforms, samplers = eclipse_inputs(sun, textures)
    defines = {**defines, **ratio_defines(recipe, len(tabled_occluders(scene, sun)), terms), "HAS_RATIO": True}
    return defines, {**uniforms, **ratio_uniforms(scene, sun, recipe)}, {**samplers, "u_ratio": texture}


class EclipseMultiple(RenderPass):
    """The volumes of ratios, a texture for each sun; made anew when sun, moons or the table without moons change."""

    name = "eclipse_multiple"
    inputs = ("visibility", *OUTPUTS)
    outputs = ("ratio",)

    def __init__(self, ctx, recipe=RATIO_RECIPES["balanced"], multiple_recipe=None):
        super().__init__(ctx, (1, 1))
        self.recipe, self.multiple_recipe = recipe, multiple_recipe
        self._key, self._textures = None, {}

    def draw(self, scene, textures):
        if "multiple_table" not in textures:
            return
        key = (scene.atmosphere, scene.suns, scene.occluders, textures["multiple_table"])
        if key != self._key:
            for texture in self._textures.values():
                self._owned.remove(texture)
                texture.release()
            self._textures = {}
            for sun in scene.suns:
                if tabled_occluders(scene, sun):
                    self._textures[sun] = self._solve(scene, sun, textures)
            self._key = key
        textures["ratio"] = dict(self._textures)

    def _solve(self, scene, sun, textures):
        recipe, moons = self.recipe, tabled_occluders(scene, sun)
        size = (recipe.rings * (recipe.coefficients + 1), recipe.sectors * recipe.heights * len(moons))
        texture = self.own(self.ctx.texture(size, 4, dtype="f4"))
        texture.filter = (self.ctx.LINEAR, self.ctx.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        textures = {**textures, "ratio": {sun: texture}}
        for number in range(len(moons)):
            _Solve(self, scene, sun, number, textures).run()
        return texture

    def release(self):
        super().release()
        self._key, self._textures = None, {}


class _Solve:
    """The volume of one moon in the light of one sun."""

    def __init__(self, owner, scene, sun, number, textures):
        self.owner, self.recipe, self.scene, self.sun = owner, owner.recipe, scene, sun
        self.number, self.textures, self.ctx = number, textures, owner.ctx
        self.moons = tabled_occluders(scene, sun)
        self.grid = RatioGrid(scene.atmosphere, sun, self.moons[number], self.recipe)

    def run(self):
        """Gather, and write the volume into its block of the texture after every gather."""
        first = self._gather(self.recipe.first, 0)
        self._write(first)
        for number in range(self.recipe.iterations):
            following = self._gather(self.recipe.later, number + 1)
            self._write([a + b for a, b in zip(first, following, strict=True)])

    def _write(self, fields):
        recipe = self.recipe
        values = self.grid.values(*fields)
        rows = values.transpose(1, 2, 0, 3, 4).reshape(recipe.heights * recipe.sectors, -1, 3)
        data = np.zeros((*rows.shape[:2], 4), np.float32)
        data[..., :3] = rows
        viewport = (0, self.number * len(rows), rows.shape[1], len(rows))
        self.textures["ratio"][self.sun].write(data.tobytes(), viewport=viewport, alignment=1)

    def _gather(self, effort, order):
        """Return the moments without the moon and with it, (2, ...), of single scattering or of a gathered source."""
        recipe, atmosphere = self.recipe, self.scene.atmosphere
        ratio = ratio_inputs(self.scene, self.sun, self.textures, recipe)
        defines = {**medium_defines(atmosphere), **transmittance_defines(atmosphere, Quality(terms=6))}
        defines |= {"AROUND": effort.around, "COLUMNS": recipe.columns}
        uniforms = {**medium_uniforms(atmosphere), **segment_uniforms(atmosphere), **multiple_uniforms(atmosphere)}
        uniforms |= cone_uniforms("u_shadow", shadow_cone(atmosphere, None, "cylinder"))
        uniforms |= {
            "u_ground_albedo": atmosphere.ground_albedo,
            "u_frame": self.grid.frame.axes,
            "u_sun_direction": self.sun.direction,
            "u_moon": self.number,
        }
        if order == 0:
            moons = eclipse_inputs(self.sun, self.textures)
            band = harmonics.band_coefficients(atmosphere.mie_g, recipe.band)
            defines |= {**moons[0], **path_defines(effort.nodes, 2), "BAND_COUNT": len(band)}
            defines["RATIO_HEIGHTS"] = recipe.heights
            del defines["GAP_CUMULATIVE_VALUES"]
            uniforms |= {**moons[1], "u_band": band}
            samplers = dict(moons[2])
        else:
            defines |= {**ratio[0], **multiple_defines(self.owner.multiple_recipe), **path_defines(effort.nodes, 2)}
            del defines["HAS_RATIO"]
            defines["HAS_ONE_MOON"] = True
            uniforms |= {**ratio[1], "u_node_count": effort.nodes}
            samplers = {**ratio[2], **multiple_samplers(self.textures)}
        return [self.grid.moments(field, effort) for field in self._draw(effort, defines, uniforms, samplers)]

    def _draw(self, effort, defines, uniforms, samplers):
        """Return two fields (heights, columns, directions, 3)."""
        recipe = self.recipe
        mu, _ = self.grid.polar(effort)
        columns = self._texture(self.grid.up[None])
        directions = self._texture(mu[..., None] * [1.0, 0.0, 0.0])
        size = (effort.polar * effort.around, recipe.heights * recipe.columns)
        samplers = {**samplers, "u_columns": columns, "u_directions": directions}
        with Target(self.ctx, size, color=("rgba32f", "rgba32f")) as target:
            target.framebuffer.use()
            self.owner.fullscreen("eclipse_multiple_gather.frag", defines, uniforms, samplers)
            fields = [target.read_color(i)[..., :3].astype(np.float64) for i in range(2)]
        columns.release()
        directions.release()
        return [field.reshape(recipe.heights, recipe.columns, size[0], 3) for field in fields]

    def _texture(self, values):
        """Upload (rows, columns, 3) as a float32 texture."""
        data = np.pad(np.asarray(values, np.float32), ((0, 0), (0, 0), (0, 1)))
        texture = self.ctx.texture(data.shape[1::-1], 4, np.ascontiguousarray(data).tobytes(), dtype="f4")
        texture.filter = (self.ctx.NEAREST, self.ctx.NEAREST)
        return texture
