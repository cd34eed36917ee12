"""The planets that the demo and the command line know by name: air, ground, sun and length of the day."""

from dataclasses import dataclass
from functools import cached_property

from shadowatmo.parameters import Atmosphere, Sun
from shadowatmo.places import Ground
from shadowatmo.presets import DENSE_EARTH, EARTH, MARS, THIN_EARTH, TITAN, TOY_PLANET
from shadowatmo.scene import Scene
from shadowatmo.surface import Surface
from shadowatmo.validation import choice

ASTRONOMICAL_UNIT = 1.495978707e11  # m (IAU 2012 resolution B2)
FAR = 1.35e7 / 6.36e6  # radii above the ground, from where a picture holds the whole planet: 13 500 km on the Earth


@dataclass(frozen=True)
class World:
    """A planet by name.

    Attributes
    ----------
    name : str
        As on the command line.
    atmosphere, surface : Atmosphere, Surface
        Its air and ground.
    sun_distance : float
        Mean distance of the sun [m].
    solar_day : float
        Mean length of the day [s].
    """

    name: str
    atmosphere: Atmosphere
    surface: Surface
    sun_distance: float
    solar_day: float

    @property
    def radius(self) -> float:
        """Radius of the ground at altitude 0 [m]."""
        return self.atmosphere.bottom_radius

    @property
    def far_height(self) -> float:
        """Height above the ground from where the whole planet is in view [m]."""
        return FAR * self.radius

    @cached_property
    def ground(self) -> Ground:
        """The altitude of the ground, place by place; the height map is read once."""
        return Ground(self.surface)

    def scene(self, sun_direction) -> Scene:
        """Return this planet with its ground and the disc of a sun in `sun_direction` (3,)."""
        sun = Sun(direction=sun_direction, distance=self.sun_distance)
        return Scene(atmosphere=self.atmosphere, suns=sun, surface=self.surface, sun_disc=True)


# Distances and days: Williams, Planetary Fact Sheets (NASA); Titan's are Saturn's distance and Titan's own orbit. The
# toy planet borrows the Earth's. Where there is no map, the ground has the atmosphere's mean albedo everywhere.
WORLDS = {
    world.name: world
    for world in (
        World("earth", EARTH, Surface.earth(), ASTRONOMICAL_UNIT, 86400.0),
        World("mars", MARS, Surface(), 1.5237 * ASTRONOMICAL_UNIT, 88775.2),
        World("thin_earth", THIN_EARTH, Surface.earth(), ASTRONOMICAL_UNIT, 86400.0),
        World("dense_earth", DENSE_EARTH, Surface.earth(), ASTRONOMICAL_UNIT, 86400.0),
        World("titan", TITAN, Surface(), 9.58 * ASTRONOMICAL_UNIT, 1.3788e6),
        World("toy_planet", TOY_PLANET, Surface(), ASTRONOMICAL_UNIT, 86400.0),
    )
}


def world(name) -> World:
    """Return a world by its name, one of WORLDS."""
    return WORLDS[choice("scene", name, tuple(WORLDS))]
