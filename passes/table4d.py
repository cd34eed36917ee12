"""The 4D table of Bruneton and Neyret 2008 for the method "table4d"."""

from shadowatmo.passes.constants import (
    air_uniforms,
    cone_uniforms,
    medium_defines,
    medium_uniforms,
    shadow_cone,
    transmittance_defines,
)
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.table_build import USUAL, InscatterTable
from shadowatmo.table4d import Table4DSize, lowest_sun, rational_sun
from shadowatmo.validation import choice

IRRADIANCE_SIZE = (64, 16)  # suns, altitudes
PUBLISHED = Table4DSize()
ORDERS = 4
LAYOUT = "packed"  # of frames
LAYOUTS = {
    "combined": ("inscatter",),
    "packed": ("inscatter", "inscatter_multiple"),
    "apart": ("inscatter", "inscatter_mie", "inscatter_multiple"),
}
LAYOUT_DEFINES = {"combined": {"HAS_PACKED": True, "HAS_COMBINED": True}, "packed": {"HAS_PACKED": True}, "apart": {}}


class Table4D(InscatterTable):
    """Inscatter over r, mu, mu_s and nu, all orders, and the irradiance of horizontal surfaces over mu_s and r.

    Parameters
    ----------
    ctx : moderngl.Context
    dimensions : Table4DSize
        Texels along the axes.
    orders : int
        Orders of scattering.
    layout : str
        "combined": one texture, the aerosols by their red channel and higher orders in the molecules' color, as
        published. "packed": the same with a texture of their own for higher orders, which the planet's shadow does not
        cut. "apart": molecules, aerosols and higher orders in three.
    effort : TableEffort
        Sample counts.
    table_format : str
        "rgba16f" or "rgba32f".
    """

    name = "table4d"
    outputs = (*LAYOUTS[LAYOUT], "sky_irradiance_table")
    feature = {"HAS_TABLE4D": True}
    species = False
    single = "table4d_single.frag"
    irradiance_size = IRRADIANCE_SIZE

    def __init__(
        self, ctx, dimensions=PUBLISHED, orders=ORDERS, layout=LAYOUT, effort=USUAL, table_format="rgba16f"
    ):
        self.dimensions, self.layout = dimensions, choice("layout", layout, tuple(LAYOUTS))
        self.outputs = (*LAYOUTS[layout], "sky_irradiance_table")
        super().__init__(ctx, dimensions.texels, orders, effort, table_format)
        targets = [Target(ctx, self.size, color=(table_format,)) for _ in LAYOUTS[layout]]
        self._stored = tuple(self.linear(self.own(target)) for target in targets)

    @property
    def stored(self):
        return self._stored

    def sizes(self):
        return table4d_sizes(self.dimensions)

    def mapping(self, atmosphere):
        return axis_uniforms(atmosphere)

    @staticmethod
    def single_uniforms(atmosphere) -> dict:
        """Return what table4d_single.frag needs beyond segments.glsl."""
        return cone_uniforms("u_shadow", shadow_cone(atmosphere, None, "cylinder"))

    def finish(self, build):
        steps = []
        if self.layout != "apart":
            combined = {"HAS_COMBINED": True} if self.layout == "combined" else {}

            def sources():
                higher = {"u_multiple": build.total.color[0]} if combined else {}
                return {**build.sources(1), **higher}

            uniforms, defines = {**build.uniforms, **build.phase}, {**build.defines, **combined}
            steps = build.banded("store", "table_store.frag", defines, uniforms, sources, lambda: self._stored[0])

        def run():
            first = 0 if self.layout == "apart" else 1
            sources = (*build.first.color, build.total.color[0])[-len(self._stored) :]
            for target, source in zip(self._stored[first:], sources[first:], strict=True):
                target.framebuffer.use()
                self.fullscreen("copy.frag", {}, {}, {"u_color": source})

        return [*steps, ("store", run)]


def table4d_sizes(dimensions) -> dict:
    """Return the defines of table4d_mapping.glsl."""
    names = ("heights", "views", "suns", "cosines")
    return {f"INSCATTER_{name.upper()}": getattr(dimensions, name) for name in names}


def table4d_defines(atmosphere, quality, dimensions, layout) -> dict:
    """Return the defines of table4d.glsl."""
    defines = {"HAS_TABLE4D": True, **table4d_sizes(dimensions), **medium_defines(atmosphere)}
    return {**defines, **transmittance_defines(atmosphere, quality), **LAYOUT_DEFINES[layout]}


def axis_uniforms(atmosphere) -> dict:
    """Return the uniforms that table4d_mapping.glsl adds to those of the air."""
    return {"u_sun_axis": rational_sun(atmosphere, lowest_sun(atmosphere))}


def table4d_uniforms(atmosphere) -> dict:
    """Return the uniforms of table4d.glsl."""
    uniforms = {**air_uniforms(atmosphere), **medium_uniforms(atmosphere), **axis_uniforms(atmosphere)}
    return {**uniforms, "u_mie_g": atmosphere.mie_g}


def table4d_method(view):
    """Return defines, uniforms and the features of each class of pixels for the method "table4d"."""
    atmosphere, quality = view.scene.atmosphere, view.quality
    lit, shadowed = {"HAS_AIR": True}, {"HAS_AIR": True, "HAS_SHADOW": True}
    to_top = {"HAS_AIR": True, "HAS_OPEN_END": True}
    defines = table4d_defines(atmosphere, quality, PUBLISHED, LAYOUT)
    return defines, table4d_uniforms(atmosphere), ({}, lit, shadowed, shadowed, to_top)
