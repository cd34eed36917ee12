"""Precomputation of a table of inscatter, order by order: what the 3D and the 4D table have in common.

The work is a list of small draws (`steps`), so that a caller may spread them over frames. One order: radiance in chosen
directions at every height and sun of the table, its mean weighted by the phase functions at every texel, and the
integral of that along every texel's path. Gathering from one row of radiances, and not from the table itself, spares
four fetches a direction; the directions are Gauss nodes split at the horizon, not a uniform grid.
"""

from dataclasses import dataclass
from importlib.resources import files

import moderngl
import numpy as np

from shadowatmo.cache import TableCache
from shadowatmo.harmonics import band_coefficients
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import (
    glsl_array,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    transmittance_defines,
)
from shadowatmo.passes.gl.textures import Target
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.quality import Quality
from shadowatmo.validation import choice, integer

STEP_TEXELS = 1 << 16  # of a table, in one draw
FORMATS = ("rgba16f", "rgba32f")
SHADERS = (  # whose text the finished tables depend on, besides the entry shader of the first order
    *(f"table_{name}.frag" for name in ("add", "density", "irradiance", "order", "radiance", "store")),
    *(f"table_{name}.glsl" for name in ("directions", "path", "shadow", "sky", "source")),
    *("table3d_mapping.glsl", "table4d_mapping.glsl", "segments.glsl", "shadow.glsl", "transmittance.glsl"),
    *("medium.glsl", "phase.glsl", "ray.glsl"),
)


@dataclass(frozen=True)
class TableEffort:
    """Sample counts of a precomputation.

    Parameters
    ----------
    nodes, gap_nodes : int
        Quadrature nodes of a lit and of a shadowed piece of a path, for single scattering.
    order_nodes : int
        Nodes of a whole path, for later orders.
    above, below, around : int
        Gathered directions: zenith angles above and below the horizon, azimuths over half a turn.
    band : int
        Degree to which the aerosols' phase function counts in a gather.
    sky : int
        Zenith angles, and azimuths over half a turn, of the irradiance of a horizontal surface.
    """

    nodes: int = 12
    gap_nodes: int = 6
    order_nodes: int = 8
    above: int = 8
    below: int = 6
    around: int = 8
    band: int = 8
    sky: int = 16

    def __post_init__(self):
        for name in ("nodes", "gap_nodes", "order_nodes"):
            integer(name, getattr(self, name), low=2, high=32)
        for name in ("above", "below", "around", "band", "sky"):
            integer(name, getattr(self, name), low=2, high=64)


USUAL = TableEffort()


class InscatterTable(RenderPass):
    """A table of inscatter and the irradiance of the ground by the sky, made anew when the air changes.

    Subclasses set `outputs`, `dimensions`, `feature`, `species` (whether molecules and aerosols stay apart in every
    order), `single` (the entry shader of the first order), and implement `sizes`, `mapping` and `finish`.

    Parameters
    ----------
    ctx : moderngl.Context
    size : (int, int)
        Of the atlas [texels].
    orders : int
        Orders of scattering, from 1.
    effort : TableEffort
        Sample counts.
    table_format : str
        Of the textures that frames read: "rgba16f" or "rgba32f". The work is done in 32 bits.
    """

    feature: dict
    species: bool
    single: str
    irradiance_size: tuple[int, int]

    def __init__(self, ctx, size, orders, effort, table_format):
        super().__init__(ctx, size)
        self.orders = integer("orders", orders, low=1, high=16)
        self.effort = effort
        self.table_format = choice("table_format", table_format, FORMATS)
        self.irradiance = self.linear(self.own(Target(ctx, self.irradiance_size, color=("rgba32f",))))
        self._atmosphere = None

    @staticmethod
    def linear(target):
        """Let a target's textures be interpolated; return the target."""
        for texture in target.color:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return target

    def sizes(self) -> dict:
        """Return the defines of the table's dimensions."""
        raise NotImplementedError

    def mapping(self, atmosphere) -> dict:
        """Return the uniforms that the mapping adds to those of the medium."""
        raise NotImplementedError

    def finish(self, build) -> list:
        """Return the steps that turn the work's textures into those that frames read."""
        raise NotImplementedError

    @property
    def stored(self) -> tuple[Target, ...]:
        """What frames read."""
        raise NotImplementedError

    @property
    def bytes(self) -> int:
        """GPU memory of what frames read."""
        return sum(target.bytes for target in (*self.stored, self.irradiance))

    @property
    def textures(self) -> dict:
        """The outputs by name, once the steps have run."""
        found = [texture for target in self.stored for texture in target.color]
        return dict(zip(self.outputs, [*found, self.irradiance.color[0]], strict=True))

    def key(self, atmosphere) -> str:
        """Return the name of the finished tables in a cache: of all that they depend on."""
        sources = (files("shadowatmo.shaders").joinpath(name).read_text("utf-8") for name in (*SHADERS, self.single))
        options = self.dimensions, self.orders, self.outputs, self.effort, self.table_format
        return TableCache.key(self.name, atmosphere, *options, *sources)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the finished tables by the names of the outputs: rows, columns, channels."""
        arrays = {}
        for name, texture in self.textures.items():
            width, height = texture.size
            arrays[name] = np.frombuffer(texture.read(alignment=1), texture.dtype).reshape(height, width, 4)
        return arrays

    def restore(self, atmosphere, arrays) -> None:
        """Take over tables that `arrays` returned, of a table of the same key."""
        for name, texture in self.textures.items():
            texture.write(np.ascontiguousarray(arrays[name]).tobytes(), alignment=1)
        self._atmosphere = atmosphere

    def draw(self, atmosphere, textures):
        if atmosphere != self._atmosphere:
            for _, run in self.steps(atmosphere):
                run()
        textures |= self.textures

    def steps(self, atmosphere) -> list:
        """Return the precomputation as (label, function without arguments), to be called in order."""
        self._atmosphere = None
        build = Build(self, atmosphere)
        steps = [("prepare", build.prepare), *build.first_order()]
        for order in range(2, self.orders + 1):
            steps += build.later_order(order)
        steps += [*build.skylight(self.orders), *self.finish(build)]

        def done():
            build.release()
            self._atmosphere = atmosphere

        return [*steps, ("done", done)]

    def release(self):
        super().release()
        self._atmosphere = None


class Build:
    """One precomputation: what its steps share. Its textures are gone after the last step."""

    def __init__(self, owner, atmosphere):
        self.owner, self.atmosphere, self.effort = owner, atmosphere, owner.effort
        self._targets = []
        self.defines = {**owner.feature, **owner.sizes(), **medium_defines(atmosphere)}
        self.defines |= transmittance_defines(atmosphere, Quality(terms=6))
        self.uniforms = {**medium_uniforms(atmosphere), **owner.mapping(atmosphere)}
        self.phase = {"u_mie_g": atmosphere.mie_g}
        series = band_coefficients(atmosphere.mie_g, self.effort.band)
        self.band = {"u_band": np.polynomial.legendre.leg2poly(series)}

    def prepare(self):
        """Make the textures of the work."""
        owner, effort = self.owner, self.effort
        pair = 2 if owner.species else 1
        self.first = self._target(owner.size, 2)
        if owner.orders > 1:
            self.gathered, self.order = self._target(owner.size, pair), self._target(owner.size, pair)
            sizes = owner.sizes()
            rows = sizes["INSCATTER_HEIGHTS"] * sizes["INSCATTER_SUNS"]
            self.radiance = self._target(((effort.above + effort.below) * effort.around, rows), 1)
        if not owner.species:
            self.total = self._target(owner.size, 1)
            self.sky = self._target(owner.irradiance_size, 1)
            self.total.framebuffer.clear()
            owner.irradiance.framebuffer.clear()

    def _target(self, size, count):
        target = self.owner.linear(Target(self.owner.ctx, size, color=("rgba32f",) * count))
        self._targets.append(target)
        return target

    def release(self):
        """Release the textures of the work."""
        while self._targets:
            self._targets.pop().release()

    def segments(self, nodes, gap_nodes=2):
        """Return defines and uniforms of segments.glsl."""
        quadrature = segment_defines(Quality(nodes=nodes, gap_nodes=gap_nodes))
        return {**self.defines, **quadrature}, {**self.uniforms, **segment_uniforms(self.atmosphere)}

    def directions(self, above, below, around):
        """Return the defines of table_directions.glsl."""
        azimuth = np.pi * (np.arange(around) + 0.5) / around
        (up, up_weights), (down, down_weights) = gauss_legendre(above), gauss_legendre(below)
        values = {"UP_NODE": up, "UP_WEIGHT": up_weights, "DOWN_NODE": down, "DOWN_WEIGHT": down_weights}
        values |= {"COSINE": np.cos(azimuth), "SINE": np.sin(azimuth)}
        arrays = {f"{name}_VALUES": glsl_array(value) for name, value in values.items()}
        counts = {"UP_COUNT": above, "DOWN_COUNT": below, "AROUND": around, "BAND_COUNT": self.effort.band + 1}
        return {**self.defines, **arrays, **counts}

    def first_order(self) -> list:
        """Single scattering."""
        defines, uniforms = self.segments(self.effort.nodes, self.effort.gap_nodes)
        uniforms |= self.owner.single_uniforms(self.atmosphere)
        return self.banded("order 1", self.owner.single, defines, uniforms, lambda: {}, lambda: self.first)

    def later_order(self, order) -> list:
        """One order from the one before."""
        owner, effort = self.owner, self.effort
        gather = self.directions(effort.above, effort.below, effort.around)
        first = {"HAS_FIRST_ORDER": True} if order == 2 else {}
        apart = {"HAS_SPECIES": True} if owner.species else {}
        label = f"order {order}"
        uniforms = {**self.uniforms, **self.phase, **self.band}
        bounce = {} if owner.species else {"HAS_GROUND": True}
        albedo = {} if owner.species else {"u_ground_albedo": self.atmosphere.ground_albedo}

        def before():
            sources = self.sources(order - 1)
            if not first and bounce:
                sources["u_sky_irradiance_table"] = self.sky.color[0]
            return sources

        radiance = {**gather, **first, **bounce, **(apart if not first else {})}
        steps = self.banded(
            label, "table_radiance.frag", radiance, {**uniforms, **albedo}, before, lambda: self.radiance
        )
        steps += self.skylight(order - 1)  # only now: the radiance took the ground's light of the order before
        steps += self.banded(
            label, "table_density.frag", {**gather, **apart}, uniforms,
            lambda: {"u_radiance": self.radiance.color[0]}, lambda: self.gathered,
        )  # fmt: skip
        defines, path = self.segments(effort.order_nodes)
        names = ("u_gathered_rayleigh", "u_gathered_mie") if owner.species else ("u_gathered",)
        steps += self.banded(
            label, "table_order.frag", {**defines, **apart}, path,
            lambda: dict(zip(names, self.gathered.color, strict=True)), lambda: self.order,
        )  # fmt: skip
        into = (lambda: self.first) if owner.species else (lambda: self.total)
        scale = 4.0 * np.pi if owner.species else 1.0  # what a deferred phase function takes away again
        return [*steps, (label, lambda: self.add(self.order, into(), scale, apart))]

    def sources(self, order):
        """Return the samplers of an order's table."""
        target = self.first if order == 1 else self.order
        return dict(zip(("u_rayleigh", "u_mie"), target.color, strict=False))

    def skylight(self, order) -> list:
        """Irradiance by one order, also into the sum; only where the ground reflects it."""
        if self.owner.species:
            return []
        defines = self.directions(self.effort.sky, 2, self.effort.sky)
        if order == 1:
            defines["HAS_FIRST_ORDER"] = True

        def run():
            self.draw_sky(defines, self.sources(order), self.sky)
            self.add(self.sky, self.owner.irradiance, 1.0, {})

        return [(f"order {order}", run)]

    def draw_sky(self, defines, sources, target):
        """Draw the irradiance of horizontal surfaces."""
        uniforms = {**self.uniforms, **self.phase, "u_irradiance_size": self.owner.irradiance_size}
        target.framebuffer.use()
        self.owner.fullscreen("table_irradiance.frag", defines, uniforms, sources)

    def add(self, source, target, scale, apart):
        """Blend one target into another."""
        ctx = self.owner.ctx
        samplers = dict(zip(("u_rayleigh", "u_mie"), source.color, strict=False))
        ctx.enable(moderngl.BLEND)
        ctx.blend_func = moderngl.ONE, moderngl.ONE
        target.framebuffer.use()
        self.owner.fullscreen("table_add.frag", apart, {"u_scale": scale}, samplers)
        ctx.disable(moderngl.BLEND)
        ctx.blend_func = moderngl.ONE, moderngl.ZERO

    def banded(self, label, fragment, defines, uniforms, samplers, target) -> list:
        """Return one draw as several, each of some rows; samplers and target are asked for when it is time."""

        def run(band, bands):
            goal = target()
            edges = np.linspace(0, goal.size[1], bands + 1).astype(int)
            low, high = int(edges[band]), int(edges[band + 1])
            goal.framebuffer.viewport = (0, low, goal.size[0], high - low)
            goal.framebuffer.use()
            self.owner.fullscreen(fragment, defines, uniforms, samplers())
            goal.framebuffer.viewport = (0, 0, *goal.size)

        bands = max(1, min(-(-self.owner.size[0] * self.owner.size[1] // STEP_TEXELS), self.owner.size[1]))
        return [(label, lambda b=band: run(b, bands)) for band in range(bands)]


def inscatter_samplers(textures) -> dict:
    """Return the samplers of table3d.glsl or table4d.glsl where there is a table."""
    return {f"u_{name}": texture for name, texture in textures.items() if name.startswith("inscatter")}
