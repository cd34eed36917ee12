"""The sky of a date and a place as command lines and the viewer ask for it: angles in degrees, a clock that runs."""

import math
from dataclasses import dataclass, field, replace
from datetime import timedelta

import numpy as np

from shadowatmo.ephemeris import YEARS, Sky, parse_date, sky_at
from shadowatmo.errors import ParameterError
from shadowatmo.places import local_axes
from shadowatmo.presets import EARTH
from shadowatmo.rigs import FlyRig
from shadowatmo.validation import number

DATE_HELP = "sun and moon of this time (UTC), as in 2017-08-21T17:21Z"
OBSERVER_HELP = "from where: degrees, metres; write --observer=-33.9,18.4,10"


def observed(planet, date, observer=None) -> Sky:
    """Return the sky over a place of a `World`.

    Parameters
    ----------
    planet : World
        One as large as the Earth.
    date : str or datetime
        As of `sky_at`.
    observer : (float, float, float), optional
        Latitude and longitude in degrees, and height [m].

    Raises
    ------
    ParameterError
        If the planet is another one, or date or observer are out of range.
    """
    if planet.radius != EARTH.bottom_radius:
        raise ParameterError("--date", str(date), f"it with a planet of the Earth's size, not with {planet.name}")
    if observer is None:
        return sky_at(date)
    return sky_at(date, observer_radians(observer))


def observer_radians(observer) -> tuple[float, float, float]:
    """Return an observer as `sky_at` takes it, from latitude and longitude in degrees and height [m]."""
    latitude = number("observer latitude", observer[0], low=-90.0, high=90.0)
    longitude = number("observer longitude", observer[1], low=-360.0, high=360.0)
    return math.radians(latitude), math.radians(longitude), number("observer height", observer[2])


def observed_scene(planet, sky):
    """Return the scene of a `World` under a sky."""
    return replace(planet.scene(sky.sun.direction), suns=sky.sun, occluders=sky.moon)


@dataclass
class SkyRig:
    """Sun and moon as a clock moves them over an observer; stands where a `SunRig` does.

    Parameters
    ----------
    planet : World
        One as large as the Earth.
    date, observer
        As of `observed`.
    """

    planet: object
    date: object
    observer: tuple[float, float, float] | None = None
    elapsed: float = field(default=0.0, init=False)

    def __post_init__(self):
        self.date = parse_date(self.date)
        self.sky = observed(self.planet, self.date, self.observer)

    @property
    def moment(self):
        """The time that the clock shows (UTC)."""
        return self.date + timedelta(seconds=self.elapsed)

    @property
    def direction(self) -> np.ndarray:
        """Unit vector (3,) to the sun."""
        return np.array(self.sky.sun.direction)

    def scene(self):
        """Return the scene of this moment."""
        return observed_scene(self.planet, self.sky)

    def camera_rig(self) -> FlyRig | None:
        """Return a flying camera at the observer that looks to the sun; None without an observer."""
        if self.sky.position is None:
            return None
        azimuth, elevation = self.sky.toward_sun()
        east, north, _ = local_axes(self.sky.position)
        ahead = math.sin(azimuth) * east + math.cos(azimuth) * north
        return FlyRig(self.planet.radius, self.planet.ground, self.sky.position, ahead, elevation)

    def advance(self, seconds) -> None:
        """Let time pass, up to the last year that is known."""
        elapsed = self.elapsed + seconds
        if (self.date + timedelta(seconds=elapsed)).year < YEARS[1]:
            self.elapsed = elapsed
            self.sky = observed(self.planet, self.moment, self.observer)

    def turn(self, position, azimuth, elevation) -> None:
        """Leave the sun where the date puts it: no key moves it."""
