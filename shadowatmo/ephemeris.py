"""Sun and moon over a place on the Earth at a time, offline, by the package ephem (extra `sky`).

Positions are apparent geocentric ones (libastro: VSOP87 for the sun, a fit to DE404 for the moon), turned by the
apparent sidereal time into the axes of `Surface.earth()`: longitude 0 on +x, 90 degrees east on +y, north on +z.

The Earth is an ellipsoid and a scene's planet a sphere. What an observer sees of sun and moon decides an eclipse to the
kilometre, so vectors from the true observer on the ellipsoid to sun and moon are kept, and begin in the scene where the
observer stands there: at the same geodetic latitude and longitude, where the scene's vertical is the true one.
Azimuths, elevations, distances and separations are so exact at the observer. Other places see a sky that is displaced
by at most the 22 km between the figures, less their likeness: nothing near the observer, kilometres over a continent.
"""

import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.errors import ParameterError, ShadowAtmoError
from shadowatmo.parameters import Occluder, Sun
from shadowatmo.places import Ground, azimuth_elevation, bearing, place
from shadowatmo.presets import EARTH
from shadowatmo.scene import Scene
from shadowatmo.surface import Surface
from shadowatmo.validation import number

EQUATOR, FLATTENING = 6378137.0, 1.0 / 298.257223563  # m, 1: WGS 84
# Espenak's k = 0.272281 of the Earth's equatorial radius, the floor of the valleys at the limb, behind which the last
# light goes; his almanacs of totality use it. The mean limb has 0.2725076 (IAU 1982), which makes totality 4 s longer.
MOON_RADIUS = 0.272281 * EQUATOR
SUN_RADIUS = 6.957e8  # m: IAU 2015 resolution B3
YEARS = (1600, 2200)  # before and after them the Earth's rotation is not known to a minute
EYE = 2.0  # m above the ground
FOV = math.radians(60.0)
HIGHEST = 1e7  # m, of an observer
SEARCH = 6.0  # h to both sides in which an eclipse is looked for
REMEDY = "places of sun and moon need the package ephem, which is not installed: `make setup`, or `pip install ephem`"


@dataclass(frozen=True)
class Sky:
    """Sun and moon at one moment, in the axes of a scene.

    Attributes
    ----------
    sun, moon : Sun, Occluder
        For a `Scene`; planet-centered.
    position : (3,) float or None
        Where the observer stands in the scene [m]; None without one.
    """

    sun: Sun
    moon: Occluder
    position: tuple[float, float, float] | None = None

    def scene(self, **fields) -> Scene:
        """Return the Earth with its ground and the sun's disc under this sky; fields as of Scene."""
        earth = {"surface": Surface.earth(), "sun_disc": True}
        return Scene(suns=self.sun, occluders=self.moon, **{**earth, **fields})

    def toward_sun(self) -> tuple[float, float]:
        """Return azimuth and elevation [rad] of the sun's center, without refraction, as the observer sees it."""
        self._require_observer()
        return azimuth_elevation(self.position, sun_center(self.sun) - self.position)

    def camera(self, azimuth=None, elevation=None, vertical_fov=FOV) -> Camera:
        """Return a camera at the observer that looks to azimuth and elevation [rad], without them to the sun."""
        toward = self.toward_sun()
        azimuth, elevation = toward[0] if azimuth is None else azimuth, toward[1] if elevation is None else elevation
        forward = bearing(self.position, number("azimuth", azimuth), number("elevation", elevation))
        return Camera(position=self.position, forward=forward, up=self.position, vertical_fov=vertical_fov)

    def _require_observer(self):
        if self.position is None:
            raise ParameterError("observer", None, "a place, for a view from there: sky_at(date, observer)")


@dataclass(frozen=True)
class Contacts:
    """Times (UTC) at which a solar eclipse begins, is whole and ends for an observer; clouds and horizon do not count.

    Attributes
    ----------
    first, last : datetime
        The moon's disc touches the sun's from outside.
    greatest : datetime
        The most is covered.
    second, third : datetime or None
        Totality or annularity begins and ends; None where the eclipse is partial.
    ratio : float
        Radius of the moon's disc over the sun's, at the greatest: above 1 in a total eclipse.
    """

    first: datetime
    second: datetime | None
    greatest: datetime
    third: datetime | None
    last: datetime
    ratio: float


def sun_center(sun) -> np.ndarray:
    """Return the position (3,) of a sun's center [m]."""
    return sun.distance * np.array(sun.direction)


def sky_at(date, observer=None, *, altitude=None) -> Sky:
    """Return where sun and moon are.

    Parameters
    ----------
    date : str or datetime
        ISO 8601, as in "2017-08-21T17:21Z"; UTC where it names no zone. Years 1600 to 2200.
    observer : (float, float, float), optional
        Latitude (geodetic, north positive) and longitude (east positive) [rad], and height [m]. Without one, positions
        are as seen from the Earth's center.
    altitude : float, optional
        Of the observer in the scene [m], whose relief is coarse; without it, the height, or 2 m above the ground of
        `Surface.earth()` where that is higher.

    Raises
    ------
    ParameterError
        If date or observer are malformed or out of range.
    ShadowAtmoError
        If ephem is missing.
    """
    moment, observer = parse_date(date), check_observer(observer)
    sun, moon = _geocentric(moment)
    position, shift = None, np.zeros(3)
    if observer is not None:
        if altitude is None:
            altitude = max(observer[2], ground().altitude(place(1.0, *observer[:2])) + EYE)
        height = number("altitude", altitude, low=-1e5, high=HIGHEST)
        position = place(EARTH.bottom_radius, *observer[:2], height)
        shift = position - on_ellipsoid(*observer)
    center = sun + shift
    return Sky(
        Sun(direction=center, distance=float(np.linalg.norm(center)), radius=SUN_RADIUS),
        Occluder(moon + shift, MOON_RADIUS),
        None if position is None else tuple(position.tolist()),
    )


@cache
def ground() -> Ground:
    """Return the altitude of the Earth's ground as scenes show it; the height map is read once."""
    return Ground(Surface.earth())


def contacts(date, observer) -> Contacts:
    """Return the times of the solar eclipse that is the nearest to a date, at most 6 hours away.

    Parameters
    ----------
    date, observer
        As of `sky_at`; the observer is needed.

    Raises
    ------
    ParameterError
        If there is no eclipse then and there, or an argument is malformed. ShadowAtmoError if ephem is missing.
    """
    moment, observer = parse_date(date), check_observer(observer)
    if observer is None:
        raise ParameterError("observer", None, "a place: latitude and longitude [rad], height [m]")
    eye = on_ellipsoid(*observer)

    def discs(hours):
        sun, moon = (center - eye for center in _geocentric(moment + timedelta(hours=float(hours))))
        separation = math.atan2(np.linalg.norm(np.cross(sun, moon)), sun @ moon)
        return math.asin(SUN_RADIUS / np.linalg.norm(sun)), math.asin(MOON_RADIUS / np.linalg.norm(moon)), separation

    def touching(hours):
        sun, moon, separation = discs(hours)
        return sun + moon - separation

    def inside(hours):
        sun, moon, separation = discs(hours)
        return abs(moon - sun) - separation

    times = np.linspace(-SEARCH, SEARCH, 721)
    nearest = times[np.argmin([discs(t)[2] for t in times])]
    greatest = _lowest(lambda t: discs(t)[2], nearest - 0.05, nearest + 0.05)
    if touching(greatest) <= 0.0:
        raise ParameterError("date", str(date), f"a time within {SEARCH:g} hours of a solar eclipse at the observer")
    span, central = 3.0, inside(greatest) > 0.0
    times = [_root(touching, greatest - span, greatest), _root(touching, greatest + span, greatest)]
    times += [_root(inside, t, greatest) if central else None for t in times]
    first, last, second, third = (None if t is None else moment + timedelta(hours=t) for t in times)
    sun, moon, _ = discs(greatest)
    return Contacts(first, second, moment + timedelta(hours=greatest), third, last, moon / sun)


def parse_date(date) -> datetime:
    """Return a date as a datetime in UTC; ParameterError if it is none or out of range."""
    allowed = f"an ISO 8601 date and time of the years {YEARS[0]} to {YEARS[1]}, as in 2017-08-21T17:21Z"
    try:
        moment = date if isinstance(date, datetime) else datetime.fromisoformat(date.strip())
        moment = moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)
    except (AttributeError, OverflowError, TypeError, ValueError):
        raise ParameterError("date", date, allowed) from None
    if not YEARS[0] <= moment.year < YEARS[1]:
        raise ParameterError("date", str(date), allowed)
    return moment


def check_observer(observer) -> tuple[float, float, float] | None:
    """Return an observer as three floats, or None for none; ParameterError if it is malformed."""
    if observer is None:
        return None
    try:
        latitude, longitude, height = observer
    except (TypeError, ValueError):
        raise ParameterError("observer", observer, "latitude [rad], longitude [rad] and height [m]") from None
    return (
        number("observer latitude", latitude, low=-math.pi / 2, high=math.pi / 2),
        number("observer longitude", longitude, low=-2.0 * math.pi, high=2.0 * math.pi),
        number("observer height", height, low=-500.0, high=HIGHEST),
    )


def on_ellipsoid(latitude, longitude, height) -> np.ndarray:
    """Return the point (3,) [m] at geodetic latitude and longitude [rad] and a height [m] above the ellipsoid."""
    squared = FLATTENING * (2.0 - FLATTENING)
    normal = EQUATOR / math.sqrt(1.0 - squared * math.sin(latitude) ** 2)
    across = (normal + height) * math.cos(latitude)
    along = (normal * (1.0 - squared) + height) * math.sin(latitude)
    return np.array([across * math.cos(longitude), across * math.sin(longitude), along])


def _geocentric(moment) -> list[np.ndarray]:
    """Return the centers of sun and moon (3,) [m] from the Earth's center, in axes that turn with the Earth."""
    try:
        import ephem
    except ModuleNotFoundError:
        raise ShadowAtmoError(REMEDY) from None
    greenwich = ephem.Observer()
    greenwich.lon, greenwich.date = 0.0, ephem.Date(moment.replace(tzinfo=None))
    turned = float(greenwich.sidereal_time())
    centers = []
    for body in (ephem.Sun(), ephem.Moon()):
        body.compute(greenwich.date, epoch=greenwich.date)  # without an observer: distance from the Earth's center
        longitude, latitude = float(body.g_ra) - turned, float(body.g_dec)
        centers.append(place(body.earth_distance * ephem.meters_per_au, latitude, longitude))
    return centers


def _root(function, low, high) -> float:
    """Return where a function changes its sign, to a thousandth of a second, for times in hours."""
    negative = function(low) < 0.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (function(middle) < 0.0) == negative else (low, middle)
    return 0.5 * (low + high)


def _lowest(function, low, high) -> float:
    """Return where a function with one minimum is the lowest, by thirds."""
    for _ in range(40):
        third = (high - low) / 3.0
        left, right = low + third, high - third
        low, high = (low, right) if function(left) < function(right) else (left, high)
    return 0.5 * (low + high)
