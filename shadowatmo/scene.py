"""What is drawn: the air, its suns, what shades it, and the planet's surface."""

from dataclasses import dataclass, replace

from shadowatmo.errors import ParameterError
from shadowatmo.parameters import Atmosphere, Occluder, Sun
from shadowatmo.presets import EARTH
from shadowatmo.ring import Ring
from shadowatmo.surface import Surface
from shadowatmo.validation import instance


@dataclass(frozen=True)
class Scene:
    """A planet in the light of its suns.

    Parameters
    ----------
    atmosphere : Atmosphere
        The air and the size of the planet.
    suns : Sun or sequence of Sun
        At least one; kept as a tuple.
    occluders : Occluder or sequence of Occluder
        Moons; kept as a tuple.
    rings : Ring or sequence of Ring
        Rings that dim the sunlight; kept as a tuple. They are not drawn.
    surface : Surface, optional
        Color and relief of the ground. None: a frame holds the light of the air alone, over a black ground.
    sun_disc : bool
        Draw the suns' discs, limb-darkened, through the air.

    Raises
    ------
    ParameterError
        If a field has another type, or there is no sun.
    """

    atmosphere: Atmosphere = EARTH
    suns: tuple[Sun, ...] = (Sun(direction=(1.0, 0.0, 0.0)),)
    occluders: tuple[Occluder, ...] = ()
    surface: Surface | None = None
    sun_disc: bool = False
    rings: tuple[Ring, ...] = ()

    def __post_init__(self):
        instance("atmosphere", self.atmosphere, Atmosphere, "an Atmosphere")
        object.__setattr__(self, "suns", _members("suns", self.suns, Sun))
        object.__setattr__(self, "occluders", _members("occluders", self.occluders, Occluder))
        object.__setattr__(self, "rings", _members("rings", self.rings, Ring))
        if not self.suns:
            raise ParameterError("suns", self.suns, "at least one Sun")
        if self.surface is not None:
            instance("surface", self.surface, Surface, "None or a Surface")
        instance("sun_disc", self.sun_disc, bool, "True or False")

    def with_sun_direction(self, direction) -> "Scene":
        """Return this scene with its first sun moved to another direction (3,)."""
        return replace(self, suns=(replace(self.suns[0], direction=direction), *self.suns[1:]))


def _members(name, value, kind) -> tuple:
    """Accept one member or a sequence of them; return a tuple."""
    if isinstance(value, kind):
        return (value,)
    try:
        members = tuple(value)
    except TypeError:
        raise ParameterError(name, value, f"a {kind.__name__} or a sequence of them") from None
    for member in members:
        instance(name, member, kind, f"a {kind.__name__} or a sequence of them")
    return members
