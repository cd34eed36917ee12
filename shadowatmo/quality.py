"""Effort, apart from physics: which method, how many nodes, which depth, and the named points "fast" to "accurate"."""

from dataclasses import dataclass

from shadowatmo.errors import ParameterError
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.validation import choice, integer, number

METHODS = ("segments", "table3d", "table3d-multiple", "table4d", "widths")
DEPTHS = ("textures", "analytic")
MAX_NODES = 32
MAX_TOLERANCE = 0.1


@dataclass(frozen=True)
class Quality:
    """How a frame is computed.

    Parameters
    ----------
    method : str
        "segments": shadow-split quadrature of single scattering; "widths": brightness by lit and shadowed path
        lengths (the published five-pass method).
    nodes : int
        Quadrature nodes of a lit piece of the ray for "segments", in [2, 32].
    gap_nodes : int
        Nodes of a shadowed piece that lies before or behind a lit one, in [2, 32].
    transmittance : str
        "closed": the Chapman closed form; "table": a table of columns over altitude and zenith angle.
    terms : int
        Terms of the closed form, 4 (relative error 5e-4) or 6 (2e-5).
    depth : str
        "textures": passes 1 to 4 write depth textures that pass 5 reads; "analytic": distances are solved per pixel
        in pass 5, as they always are from so far away that a 32-bit distance cannot tell 1/2000 of the air's depth.
    depth_bits : int
        32: reversed float depth, distances re-derived per pixel; 24: the published standard depth of the rasterized
        proxies.
    shadow : str
        Shape of the planet's shadow in the frame: "cylinder" for the parallel sun, "cone" for the true umbra.
    orders : int or str
        1: single scattering alone; "all": light scattered more than once too, with the ground's reflections.
    multiple : str
        Resolution of the table of multiple scattering, "balanced" or "accurate" (multiple_recipes.RECIPES).
    tolerance : float
        0: every pixel is evaluated; else the largest second difference, relative to the pixel, that a tile of 8 x 8
        pixels may carry and still be interpolated between its corners, in [0, 0.1].
    """

    method: str = "segments"
    nodes: int = 8
    gap_nodes: int = 4
    transmittance: str = "closed"
    terms: int = 4
    depth: str = "textures"
    depth_bits: int = 32
    shadow: str = "cylinder"
    orders: int | str = "all"
    multiple: str = "balanced"
    tolerance: float = 0.0

    def __post_init__(self):
        choice("method", self.method, METHODS)
        integer("nodes", self.nodes, low=2, high=MAX_NODES)
        integer("gap_nodes", self.gap_nodes, low=2, high=MAX_NODES)
        choice("transmittance", self.transmittance, ("closed", "table"))
        choice("terms", self.terms, (4, 6))
        choice("depth", self.depth, DEPTHS)
        choice("depth_bits", self.depth_bits, (24, 32))
        choice("shadow", self.shadow, ("cylinder", "cone"))
        choice("orders", self.orders, (1, "all"))
        choice("multiple", self.multiple, tuple(RECIPES))
        object.__setattr__(self, "tolerance", number("tolerance", self.tolerance, low=0, high=MAX_TOLERANCE))


NAMED = {
    "fast": Quality(nodes=6, depth="analytic"),
    "balanced": Quality(depth="analytic"),
    "accurate": Quality(nodes=20, gap_nodes=10, terms=6, multiple="accurate"),
}


def as_quality(value) -> Quality:
    """Return a Quality from one, or from the name of one ("fast", "balanced", "accurate")."""
    if isinstance(value, Quality):
        return value
    if isinstance(value, str) and value in NAMED:
        return NAMED[value]
    raise ParameterError("quality", value, "a Quality or one of " + ", ".join(repr(n) for n in NAMED))
