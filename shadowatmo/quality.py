"""Effort, apart from physics: which method, how many nodes, which depth, and the named points "fast" to "accurate"."""

from dataclasses import InitVar, dataclass, field, fields

from shadowatmo.errors import ParameterError
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.validation import choice, integer, number

METHODS = ("segments", "march", "table3d", "table3d-multiple", "table4d", "widths")
PATH_METHODS = ("segments", "march")  # sums along the path; multiple scattering is added to them
DEPTHS = ("textures", "analytic")
MAX_NODES = 32
MAX_STEPS = 1024
MAX_TOLERANCE = 0.1


@dataclass(frozen=True)
class Quality:
    """How a frame is computed: field by field, or by a budget.

    `Quality(error=0.01)` is the cheapest measured quality that keeps an error, `Quality(cost=20)` the most accurate one
    at a cost (shadowatmo.budget). Fields given beside a budget are kept: it chooses among the measured qualities that
    have them. What comes out is a quality like any other, equal to one that was spelled out; `budget` says why it was
    chosen, until `dataclasses.replace` makes another of it.

    Parameters
    ----------
    method : str
        "segments": shadow-split quadrature of single scattering; "march": uniform steps over the whole path and a
        table of columns, the usual practice; "table3d", "table3d-multiple", "table4d": published tables of inscatter;
        "widths": brightness by lit and shadowed path lengths (the published five-pass method).
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
    steps : int
        Uniform steps of a path for "march", in [1, 1024].
    multiple : str
        Resolution of the table of multiple scattering (multiple_recipes.RECIPES): "balanced", "accurate", "finest", or
        "truth", by which the report judges the others.
    tolerance : float
        0: every pixel is evaluated; else the largest second difference, relative to the pixel, that a tile of 8 x 8
        pixels may carry and still be interpolated between its corners, in [0, 0.1].
    error : float, optional
        Budget: relative error of light, absolute error of transmittance, that 95 of 100 rays keep; > 0.
    cost : float, optional
        Budget: full-screen copies that a frame takes at most, > 0. Give `error` or `cost`.

    Attributes
    ----------
    budget : str
        What a budget chose, and why; empty without one.

    Raises
    ------
    ParameterError
        If a field is out of range, or no measured quality keeps the budget with the fields given.
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
    steps: int = 32
    tolerance: float = 0.0
    error: InitVar[float | None] = None
    cost: InitVar[float | None] = None
    budget: str = field(default="", init=False, compare=False, repr=False)

    def __new__(cls, *args, **given):
        """Remember which fields the caller names beside a budget: defaults are no wishes."""
        made = super().__new__(cls)
        if given.get("error") is not None or given.get("cost") is not None:
            named = {f.name for f in fields(cls)[: len(args)]} | given.keys() - {"error", "cost"}
            object.__setattr__(made, "_named", named)
        return made

    def __post_init__(self, error, cost):
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
        integer("steps", self.steps, low=1, high=MAX_STEPS)
        object.__setattr__(self, "tolerance", number("tolerance", self.tolerance, low=0, high=MAX_TOLERANCE))
        if error is not None or cost is not None:
            self._keep_budget(error, cost)

    def _keep_budget(self, error, cost):
        """Take the fields of the measured quality that a budget chooses."""
        from shadowatmo.budget import choose  # it reads the curve, which is made of qualities

        choice_ = choose(error, cost, {name: getattr(self, name) for name in self._named})
        object.__delattr__(self, "_named")
        for name, value in {**choice_.fields, "budget": choice_.reason}.items():
            object.__setattr__(self, name, value)

    @property
    def column_table(self) -> bool:
        """Whether the table of columns is read; "march" always does, "widths" never."""
        return self.method == "march" or (self.transmittance == "table" and self.method != "widths")


NAMED = {
    "fast": Quality(nodes=6, depth="analytic", tolerance=0.02),
    "balanced": Quality(depth="analytic", tolerance=0.006),
    "accurate": Quality(nodes=20, gap_nodes=12, terms=6, depth="analytic", multiple="accurate", tolerance=0.001),
}


def as_quality(value) -> Quality:
    """Return a Quality from one, or from the name of one ("fast", "balanced", "accurate")."""
    if isinstance(value, Quality):
        return value
    if isinstance(value, str) and value in NAMED:
        return NAMED[value]
    raise ParameterError("quality", value, "a Quality or one of " + ", ".join(repr(n) for n in NAMED))
