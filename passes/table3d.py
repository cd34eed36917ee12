"""The 3D tables of Schafhitzel 2007 ("table3d") and Elek 2009 ("table3d-multiple")."""

import math

from shadowatmo.passes.constants import medium_defines, medium_uniforms, transmittance_defines
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.table_build import USUAL, InscatterTable
from shadowatmo.table3d import Table3DSize

SCHAFHITZEL = Table3DSize()
ELEK = Table3DSize(heights=32, views=256, suns=32, mapping="curved")
METHOD_TABLES = {"table3d": (SCHAFHITZEL, 1), "table3d-multiple": (ELEK, 6)}  # dimensions, and how many are all orders
AMBIENT_TEXELS = 256
# by class: no air, one lit piece, one lit piece and a shadow, a shadow between two lit pieces
CLASS_FEATURES = (
    {},
    {"HAS_AIR": True},
    {"HAS_AIR": True, "HAS_SHADOW": True},
    {"HAS_AIR": True, "HAS_SHADOW": True, "HAS_TWO_PIECES": True},
)
OUTPUTS = ("inscatter", "inscatter_mie")


class Table3D(InscatterTable):
    """Inscatter over height, view zenith and sun zenith, molecules and aerosols, and the ambient light over the sun's.

    With one order phases are true; with more, the sum is for the phase functions of `table3d_defines` (Elek, eq. 14
    and 15), and the ground reflects nothing: both as published. The sum's phases are deferred, so a later order is
    stored 4 pi times.

    Parameters
    ----------
    ctx : moderngl.Context
    dimensions : Table3DSize
        Texels along the axes, and their mapping.
    orders : int
        Orders of scattering.
    effort : TableEffort
        Sample counts.
    table_format : str
        "rgba16f" or "rgba32f".
    """

    name = "table3d"
    outputs = (*OUTPUTS, "sky_irradiance_table")
    species = True
    single = "table3d_single.frag"
    irradiance_size = (AMBIENT_TEXELS, 1)

    def __init__(self, ctx, dimensions=SCHAFHITZEL, orders=1, effort=USUAL, table_format="rgba16f"):
        self.dimensions = dimensions
        self.feature = table3d_features(dimensions)
        super().__init__(ctx, dimensions.texels, orders, effort, table_format)
        self._stored = self.linear(self.own(Target(ctx, self.size, color=(table_format,) * 2)))

    @property
    def stored(self):
        return (self._stored,)

    def sizes(self):
        return table3d_sizes(self.dimensions)

    def mapping(self, atmosphere):
        return {"u_sun_azimuth": math.cos(self.dimensions.azimuth)}

    @staticmethod
    def single_uniforms(atmosphere) -> dict:
        """Return what table3d_single.frag needs beyond segments.glsl: nothing."""
        return {}

    def finish(self, build):
        apart = {"HAS_SPECIES": True}

        def store():
            self._stored.framebuffer.clear()
            build.add(build.first, self._stored, 1.0, apart)

        def ambient():
            effort = self.effort
            defines = build.directions(effort.sky, 2, effort.sky) | {"HAS_FIRST_ORDER": True}
            if self.orders > 1:
                defines["HAS_AD_HOC_PHASE"] = True
            build.draw_sky(defines, build.sources(1), self.irradiance)

        return [("store", store), ("ambient", ambient)]


def table3d_features(dimensions) -> dict:
    """Return the features of table3d_mapping.glsl."""
    return {"HAS_TABLE3D": True, **({"HAS_CURVED_MAPPING": True} if dimensions.mapping == "curved" else {})}


def table3d_sizes(dimensions) -> dict:
    """Return the defines of table3d_mapping.glsl."""
    sizes = {f"INSCATTER_{name.upper()}": getattr(dimensions, name) for name in ("heights", "views", "suns")}
    return {**sizes, "INSCATTER_COLUMNS": dimensions.columns}


def table3d_defines(atmosphere, quality, dimensions, orders) -> dict:
    """Return the defines of table3d.glsl; more than one order takes the ad-hoc phase of the molecules."""
    defines = {**table3d_features(dimensions), **table3d_sizes(dimensions), **medium_defines(atmosphere)}
    defines |= transmittance_defines(atmosphere, quality)
    return {**defines, **({"HAS_AD_HOC_PHASE": True} if orders > 1 else {})}


def table3d_uniforms(atmosphere, dimensions) -> dict:
    """Return the uniforms of table3d.glsl."""
    azimuth = math.cos(dimensions.azimuth)
    return {**medium_uniforms(atmosphere), "u_mie_g": atmosphere.mie_g, "u_sun_azimuth": azimuth}


def table3d_method(view):
    """Return defines, uniforms and the features of each class of pixels for "table3d" and "table3d-multiple"."""
    atmosphere, quality = view.scene.atmosphere, view.quality
    dimensions, orders = METHOD_TABLES[quality.method]
    defines = table3d_defines(atmosphere, quality, dimensions, 1 if quality.orders == 1 else orders)
    return defines, table3d_uniforms(atmosphere, dimensions), CLASS_FEATURES
