"""The table methods: which table a quality asks for, and what a probe reads from it for single rays."""

import numpy as np

from shadowatmo.passes.constants import cone_uniforms
from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.table3d import METHOD_TABLES, Table3D, table3d_defines, table3d_uniforms
from shadowatmo.passes.table4d import LAYOUT, ORDERS, PUBLISHED, Table4D, table4d_defines, table4d_uniforms
from shadowatmo.passes.table_build import inscatter_samplers
from shadowatmo.passes.tables import TableKeeper
from shadowatmo.quality import Quality
from shadowatmo.shadow import cylinder

TABLE_METHODS = (*METHOD_TABLES, "table4d")


def method_orders(quality) -> int:
    """Return how many orders the table of a quality's method sums."""
    if quality.orders == 1:
        return 1
    return ORDERS if quality.method == "table4d" else METHOD_TABLES[quality.method][1]


def make_table(ctx, method, orders):
    """Return a new table of a method, not yet drawn."""
    if method == "table4d":
        return Table4D(ctx, orders=orders)
    return Table3D(ctx, METHOD_TABLES[method][0], orders=orders)


def table_light(ctx, atmosphere, quality, draw, textures, moons) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return single, multiple and ground_multiple (N, 3) of rays for one sun of irradiance 1.

    Two tables tell the orders apart, of the first one alone and of all; the context keeps them for the next call.

    Parameters
    ----------
    ctx : moderngl.Context
    atmosphere : Atmosphere
    quality : Quality
        Its method is one of TABLE_METHODS.
    draw : callable
        (fragment, defines, uniforms, textures, outputs) -> list of (N, 4) arrays, one ray per row.
    textures : dict
        u_ray, u_axis and u_limits of table_probe.frag, and u_base and u_direction where moons shade the air.
    moons : tuple of dict
        Defines, uniforms and samplers of eclipse.glsl.
    """
    single, _ = _light(ctx, atmosphere, quality, 1, draw, textures, moons)
    orders = method_orders(quality)
    if orders == 1:
        return single, np.zeros_like(single), np.zeros_like(single)
    total, ground = _light(ctx, atmosphere, quality, orders, draw, textures, moons)
    return single, total - single, ground


def release_probe_tables(ctx) -> None:
    """Release the tables that `table_light` keeps."""
    keepers = context_store(ctx).pop("probe_inscatter", {})
    while keepers:
        keepers.popitem()[1].release()


def _light(ctx, atmosphere, quality, orders, draw, textures, moons):
    """Return radiance and skylight off the ground (N, 3) by the table of some orders."""
    method, tables = quality.method, {}
    keepers = context_store(ctx).setdefault("probe_inscatter", {})
    if (method, orders) not in keepers:
        keepers[method, orders] = TableKeeper(ctx, lambda: make_table(ctx, method, orders))
    keepers[method, orders].draw(atmosphere, tables)
    columns = Quality(terms=quality.terms)  # in closed form
    if method == "table4d":
        defines = table4d_defines(atmosphere, columns, PUBLISHED, LAYOUT) | {"HAS_SHADOW": True}
        uniforms = table4d_uniforms(atmosphere)
    else:
        dimensions = METHOD_TABLES[method][0]
        defines = table3d_defines(atmosphere, columns, dimensions, orders)
        defines |= {"HAS_SHADOW": True, "HAS_TWO_PIECES": True}
        uniforms = table3d_uniforms(atmosphere, dimensions)
    uniforms |= cone_uniforms("u_shadow", cylinder(atmosphere.bottom_radius))
    uniforms["u_ground_albedo"] = atmosphere.ground_albedo
    samplers = inscatter_samplers(tables) | {"u_sky_irradiance_table": tables["sky_irradiance_table"]}
    if moons[0]:
        defines |= moons[0]
        uniforms |= moons[1]
        samplers |= moons[2]
    outputs = draw("table_probe.frag", defines, uniforms, {**textures, **samplers}, 2)
    return tuple(output[:, :3].astype(np.float64) for output in outputs)
