"""Multiple scattering: solves the table of multiple.glsl on the GPU, order by order, when the air changes.

The solve is a list of small draws (`steps`), so that a caller may spread them over frames. Each order is gathered from
the table of the one before; its moments are kept, and their sum with a geometric tail is the final table. The constants
of every linear step come from the twin in float64.
"""

from functools import lru_cache
from importlib.resources import files

import numpy as np

from shadowatmo import harmonics, multiple, multiple_axes
from shadowatmo.cache import TableCache
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import (
    cone_uniforms,
    glsl_array,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    shadow_cone,
    transmittance_defines,
)
from shadowatmo.passes.gl.textures import Target
from shadowatmo.quadrature import cumulative_matrix
from shadowatmo.quality import Quality

OUTPUTS = ("multiple_table", "multiple_level", "ground_irradiance", "aureole_table")
SHADERS = ("ray.glsl", "shadow.glsl", "medium.glsl", "phase.glsl", "transmittance.glsl", "segments.glsl") + tuple(
    f"multiple{rest}"
    for rest in (
        ".glsl", "_path.glsl", "_field.glsl", "_gather.frag", "_fourier.frag", "_moments.frag", "_scale.frag",
        "_level.frag", "_mix.frag", "_resolve.frag",
    )
)  # fmt: skip
TWINS = ("harmonics.py", "multiple.py", "multiple_axes.py", "extremes.py")
LEVEL_PARTS = 3  # of the level's texture, one over the other
BANDS = 4  # draws that a gather is cut into


def multiple_defines(recipe) -> dict:
    """Return the defines of multiple.glsl for the lookup of a recipe's table."""
    texels = {"MULTIPLE_FINER": multiple_axes.FINER, "AUREOLE_TEXELS": multiple.AUREOLE_TEXELS}
    return {"HAS_MULTIPLE": True, **_sizes(recipe), **texels, "MULTIPLE_FINER_HEIGHTS": multiple_axes.FINER_HEIGHTS}


def multiple_uniforms(atmosphere) -> dict:
    """Return the uniforms that multiple.glsl adds to those of the medium."""
    low, high = multiple_axes.sun_range(atmosphere)
    mapping = {"u_sun_mapping": (multiple_axes.SUN_WIDTH, low, high - low)}
    return {**mapping, "u_highest_layer": multiple_axes.highest_layer(atmosphere)}


def multiple_samplers(textures) -> dict:
    """Return the samplers of multiple.glsl."""
    return {f"u_{name}": textures[name] for name in OUTPUTS}


def path_defines(nodes, gap_nodes) -> dict:
    """Return the quadrature constants of segments.glsl and multiple_path.glsl."""
    values = segment_defines(Quality(nodes=nodes, gap_nodes=gap_nodes))
    return {**values, "GAP_CUMULATIVE_VALUES": _gap_values(gap_nodes)}


@lru_cache(maxsize=64)
def _gap_values(gap_nodes):
    return glsl_array(cumulative_matrix(gap_nodes).ravel())


def _sizes(recipe):
    names = ("heights", "suns", "layers", "polar", "azimuths")
    return {f"MULTIPLE_{name.upper()}": getattr(recipe, name) for name in names}


class MultipleScattering(RenderPass):
    """The table of multiple scattering, its level, skylight on the ground, and the aureole's kernel.

    Parameters
    ----------
    ctx : moderngl.Context
    recipe : Recipe
        Resolution of the solver.
    table_format : str
        Of the table: "rgba16f", or "rgba32f" for tests.
    """

    name = "multiple"
    outputs = OUTPUTS

    def __init__(self, ctx, recipe=RECIPES["balanced"], table_format="rgba16f"):
        super().__init__(ctx, (recipe.suns * recipe.polar, recipe.layers * recipe.azimuths))
        self.recipe = recipe
        finer = multiple_axes.FINER * (recipe.suns - 1) + 1
        rows = multiple_axes.FINER_HEIGHTS * (recipe.heights - 1) + 1
        sizes = (self.size, (finer, LEVEL_PARTS * rows), (finer, 1))
        formats = (table_format, "rgba32f", "rgba32f")
        self.table, self.level, self.ground = (
            self.own(Target(ctx, size, color=(form,))) for size, form in zip(sizes, formats, strict=True)
        )
        for target in (self.table, self.level, self.ground):
            target.color[0].filter = (ctx.LINEAR, ctx.LINEAR)
        self._aureole = None
        self._work, self._atmosphere = [], None

    @property
    def bytes(self) -> int:
        """GPU memory of the tables, without what the solve needs for a while."""
        return self.table.bytes + self.level.bytes + self.ground.bytes + 16 * multiple.AUREOLE_TEXELS

    def draw(self, atmosphere, textures):
        if atmosphere != self._atmosphere:
            for _, run in self.steps(atmosphere):
                run()
        textures |= self.textures

    @property
    def textures(self) -> dict:
        """The outputs by name, once the steps have run."""
        found = (self.table.color[0], self.level.color[0], self.ground.color[0], self._aureole)
        return dict(zip(OUTPUTS, found, strict=True))

    def key(self, atmosphere) -> str:
        """Return the name of the finished tables in a cache: of all that they depend on."""
        sources = (files("shadowatmo.shaders").joinpath(name).read_text("utf-8") for name in SHADERS)
        twins = (files("shadowatmo").joinpath(name).read_text("utf-8") for name in TWINS)
        return TableCache.key(self.name, atmosphere, self.recipe, self.table.formats, *sources, *twins)

    def arrays(self) -> dict:
        """Return the finished tables, by the names of the outputs."""
        return {name: texture_array(texture) for name, texture in self.textures.items()}

    def restore(self, atmosphere, arrays) -> None:
        """Take over tables that `arrays` returned."""
        for name, target in zip(OUTPUTS, (self.table, self.level, self.ground), strict=False):
            target.color[0].write(np.ascontiguousarray(arrays[name]).tobytes(), alignment=1)
        self._replace_aureole(aureole_texture(self.ctx, arrays["aureole_table"]), atmosphere)

    def steps(self, atmosphere) -> list:
        """Return the solve as a list of (label, function without arguments), to be called in order."""
        solve = _Solve(self, atmosphere)
        steps = [("prepare", solve.prepare)]
        for order in range(self.recipe.orders):
            for band in range(BANDS):
                steps.append((f"order {order + 1}: gather", lambda o=order, b=band: solve.gather(o, b)))
            steps.append((f"order {order + 1}: moments", lambda o=order: solve.moments(o)))
            last = order == self.recipe.orders - 1
            steps.append((f"order {order + 1}: table", lambda o=order, s=last: solve.resolve(o, s)))
        return [*steps, ("finish", solve.finish)]

    def _replace_aureole(self, texture, atmosphere):
        if self._aureole is not None:
            self._owned.remove(self._aureole)
            self._aureole.release()
        self._aureole, self._atmosphere = self.own(texture), atmosphere

    def release(self):
        super().release()
        self._aureole, self._atmosphere = None, None


def texture_array(texture) -> np.ndarray:
    """Return a texture's contents (rows, columns, channels), row 0 at the bottom."""
    kind = {"f2": np.float16, "f4": np.float32}[texture.dtype]
    return np.frombuffer(texture.read(alignment=1), kind).reshape(*texture.size[::-1], texture.components)


def aureole_texture(ctx, values):
    """Upload the aureole's kernel (1, texels, 4)."""
    data = np.ascontiguousarray(values, np.float32)
    texture = ctx.texture((data.shape[1], 1), 4, data.tobytes(), dtype="f4")
    texture.filter = (ctx.LINEAR, ctx.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


class _Gathering:
    """An effort as the shaders take it: constants and targets."""

    def __init__(self, solve, effort):
        recipe, atmosphere = solve.recipe, solve.atmosphere
        self.effort = effort
        altitude = multiple_axes.height_of(atmosphere, np.linspace(0.0, 1.0, recipe.heights))
        mu, weights = multiple.gather_polar(atmosphere, altitude, effort.above, effort.below)
        basis = harmonics.polar_basis(mu, recipe.degree)
        up = np.maximum(mu, 0.0)[..., None]
        self.directions = solve.texture(mu)
        self.basis = solve.texture((weights[..., None] * np.concatenate([basis, up], axis=-1)).reshape(-1, solve.count))
        turns = np.cos(np.outer(np.arange(recipe.degree + 1), effort.azimuths))
        self.turns = (2 * np.pi / effort.around * turns).ravel()
        rows = recipe.heights * recipe.suns
        self.radiance = solve.target((effort.polar * effort.around, rows))
        self.fourier = solve.target((effort.polar * (recipe.degree + 1), rows))


class _Solve:
    """One solve: what its steps share. Textures made here are gone after `finish`."""

    def __init__(self, owner, atmosphere):
        self.owner, self.recipe, self.atmosphere = owner, owner.recipe, atmosphere
        self.ctx = owner.ctx
        self.rows = self.recipe.heights * self.recipe.suns
        l, m = harmonics.harmonic_indices(self.recipe.degree)  # noqa: E741
        self.l, self.m = l, np.append(m, 0)
        self.count = len(self.m)  # coefficients, and last the irradiance
        self._resources = []

    def texture(self, values):
        """Upload (rows, columns) or (rows, columns, 3) as a float32 texture."""
        values = np.asarray(values, np.float32)
        if values.ndim == 3:
            values = np.concatenate([values, np.zeros((*values.shape[:2], 1), np.float32)], axis=-1)
        components = 1 if values.ndim == 2 else 4
        texture = self.ctx.texture(values.shape[1::-1], components, np.ascontiguousarray(values).tobytes(), dtype="f4")
        texture.filter = (self.ctx.NEAREST, self.ctx.NEAREST)
        self._resources.append(texture)
        return texture

    def target(self, size):
        """Make a float32 target of the solve."""
        target = Target(self.ctx, size, color=("rgba32f",))
        self._resources.append(target)
        return target

    def prepare(self):
        """Make the constants and the targets."""
        recipe, atmosphere = self.recipe, self.atmosphere
        first = _Gathering(self, recipe.first)
        self.gatherings = first, first if recipe.later == recipe.first else _Gathering(self, recipe.later)
        self.phases = self.texture(harmonics.phase_moments(atmosphere.mie_g, recipe.degree)[None, self.l])
        self.polar = self.texture(multiple_axes.polar_fit(recipe.polar, recipe.degree))
        self.turns = multiple_axes.azimuth_fit(recipe.azimuths, recipe.degree).ravel()
        self.all_moments = self.target((self.count * recipe.orders, self.rows))
        table_rows = recipe.layers * recipe.suns
        self.scaled = self.target((self.count - 1, table_rows))
        self.source = self.target((recipe.polar * (recipe.degree + 1), table_rows))
        cosine = 1.0 - 2.0 * np.linspace(0.0, 1.0, multiple.AUREOLE_TEXELS) ** 2
        kernel = harmonics.aureole_kernel(atmosphere.mie_g, recipe.degree, cosine)
        self.aureole = aureole_texture(self.ctx, np.pad(kernel, ((0, 0), (0, 1)))[None])
        self._resources.append(self.aureole)

    def gather(self, order, band):
        """Step 1: radiance of an order, one band of altitudes."""
        gathering, atmosphere = self.gatherings[min(order, 1)], self.atmosphere
        effort = gathering.effort
        defines = {**medium_defines(atmosphere), **transmittance_defines(atmosphere, Quality(terms=6))}
        defines |= {**path_defines(effort.nodes, effort.gap_nodes), **_sizes(self.recipe), "AROUND": effort.around}
        uniforms = {**medium_uniforms(atmosphere), **segment_uniforms(atmosphere), **multiple_uniforms(atmosphere)}
        uniforms |= cone_uniforms("u_shadow", shadow_cone(atmosphere, None, "cylinder"))
        uniforms["u_ground_albedo"] = atmosphere.ground_albedo
        samplers = {"u_directions": gathering.directions}
        if order == 0:
            band_values = harmonics.band_coefficients(atmosphere.mie_g, self.recipe.band)
            defines["BAND_COUNT"] = len(band_values)
            uniforms["u_band"] = band_values
        else:
            defines |= multiple_defines(self.recipe)
            samplers |= multiple_samplers({**self.owner.textures, "aureole_table": self.aureole})
        low, high = (self.rows * i // BANDS for i in (band, band + 1))
        part = 0, low, gathering.radiance.size[0], high - low
        self._draw("multiple_gather.frag", defines, uniforms, samplers, gathering.radiance, part)

    def moments(self, order):
        """Steps 2 and 3: coefficients of the spherical harmonics."""
        gathering = self.gatherings[min(order, 1)]
        polar = {"POLAR_COUNT": gathering.effort.polar}
        defines = {**polar, "AROUND": gathering.effort.around, "TURN_COUNT": len(gathering.turns)}
        samplers = {"u_radiance": gathering.radiance.color[0]}
        self._draw("multiple_fourier.frag", defines, {"u_turns": gathering.turns}, samplers, gathering.fourier)
        samplers = {"u_fourier": gathering.fourier.color[0], "u_basis": gathering.basis}
        defines = {**polar, "MULTIPLE_SUNS": self.recipe.suns, "COEFFICIENTS": self.count}
        uniforms = {"u_degrees": self.m, "u_first_column": order * self.count}
        part = order * self.count, 0, self.count, self.rows
        self._draw("multiple_moments.frag", defines, uniforms, samplers, self.all_moments, part)

    def resolve(self, order, last):
        """Steps 4 to 6: the table of this order's field, or after the last of the sum over all."""
        recipe = self.recipe
        defines = {"MULTIPLE_SUNS": recipe.suns}
        if last:
            defines |= {"HAS_SUM": True, "ORDERS": recipe.orders}
        uniforms = {} if last else {"u_first_column": order * self.count}
        field = {"u_moments": self.all_moments.color[0]}
        defines |= {"MULTIPLE_HEIGHTS": recipe.heights, "COEFFICIENTS": self.count}
        step = {"u_layer_step": multiple_axes.layer_step(self.atmosphere, recipe)}
        samplers = {**field, "u_phase_moments": self.phases}
        self._draw("multiple_scale.frag", defines, {**uniforms, **step}, samplers, self.scaled)
        defines |= {"MULTIPLE_FINER": multiple_axes.FINER, "MULTIPLE_FINER_HEIGHTS": multiple_axes.FINER_HEIGHTS}
        defines["DEGREE"] = recipe.degree
        self._draw("multiple_level.frag", defines, uniforms, field, self.owner.level)
        self._draw("multiple_level.frag", {**defines, "HAS_GROUND": True}, uniforms, field, self.owner.ground)
        defines = {"MULTIPLE_POLAR": recipe.polar, "DEGREE": recipe.degree}
        samplers = {"u_scaled": self.scaled.color[0], "u_polar": self.polar}
        self._draw("multiple_mix.frag", defines, {}, samplers, self.source)
        defines |= {"MULTIPLE_LAYERS": recipe.layers, "MULTIPLE_SUNS": recipe.suns, "TURN_COUNT": len(self.turns)}
        samplers = {"u_source": self.source.color[0]}
        self._draw("multiple_resolve.frag", defines, {"u_turns": self.turns}, samplers, self.owner.table)

    def finish(self):
        """Hand the aureole's kernel over and release everything else."""
        self._resources.remove(self.aureole)
        self.owner._replace_aureole(self.aureole, self.atmosphere)
        while self._resources:
            self._resources.pop().release()

    def _draw(self, fragment, defines, uniforms, samplers, target, part=None):
        target.framebuffer.viewport = part or (0, 0, *target.size)
        target.framebuffer.use()
        self.owner.fullscreen(fragment, defines, uniforms, samplers)
