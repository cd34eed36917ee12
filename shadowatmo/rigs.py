"""What holds a camera or turns the sun, moved by hands: orbit, flight, and the apparent sun. Nothing here draws.

Rigs keep their state in planet-centered float64 and know the ground, so that no camera ever goes below it. Angles are
in radians, lengths in metres, times in seconds.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.places import Ground, azimuth_elevation, bearing, local_axes, rotate

LOWEST, HIGHEST = 2.0, 1e8  # m above the ground
NADIR_ABOVE, HORIZON_BELOW = 1e7, 1e5  # m: an orbiting camera looks down above the one and ahead below the other
HIGHEST_LOOK = math.radians(170.0)  # of an orbiting camera's view axis from straight down
STEEPEST = math.radians(89.0)  # of a flying camera's pitch
WHEEL_STEP = 1.25  # factor on the altitude of one notch of the wheel
SPEED = 0.8  # altitudes a second
SLOWEST = 10.0  # m: the altitude that sets the speed is at least this


def clamp(value, low, high):
    """Return the value inside [low, high] that is nearest."""
    return min(max(value, low), high)


@dataclass
class OrbitRig:
    """A camera above a point of the planet; it looks down from far away and ahead when it is low.

    Parameters
    ----------
    radius : float
        Of the planet [m].
    ground : Ground
        Altitude of the ground.
    up : (3,) float
        Unit vector from the planet's center to the camera.
    ahead : (3,) float
        Unit vector along the ground that is at the top of the picture.
    height : float
        Above the ground [m], in [2, 1e8].
    tilt : float
        Added to the angle between straight down and the view axis.
    """

    radius: float
    ground: Ground
    up: np.ndarray
    ahead: np.ndarray
    height: float = 1.2e7
    tilt: float = 0.0
    fov: float = math.radians(50.0)

    @property
    def altitude(self) -> float:
        """Altitude of the camera [m]."""
        return self.ground.altitude(self.up) + self.height

    @property
    def position(self) -> np.ndarray:
        """Where the camera is (3,) [m]."""
        return (self.radius + self.altitude) * self.up

    def angle(self) -> float:
        """Return the angle between straight down and the view axis."""
        return clamp(self._untilted() + self.tilt, 0.0, HIGHEST_LOOK)

    def _untilted(self) -> float:
        """Return that angle as the height alone sets it: 0 from far away, the horizon's when low."""
        step = clamp(math.log(NADIR_ABOVE / self.height) / math.log(NADIR_ABOVE / HORIZON_BELOW), 0.0, 1.0)
        horizon = math.asin(self.radius / (self.radius + max(self.altitude, 0.0)))
        return step * step * (3.0 - 2.0 * step) * horizon

    def camera(self) -> Camera:
        """Return the camera."""
        cosine, sine = math.cos(self.angle()), math.sin(self.angle())
        forward = sine * self.ahead - cosine * self.up
        return Camera(
            position=self.position, forward=forward, up=cosine * self.ahead + sine * self.up, vertical_fov=self.fov
        )

    def drag(self, dx, dy) -> None:
        """Move the ground with the pointer; dx, dy = movement to the right and down in picture heights."""
        reach = clamp(2.0 * math.tan(self.fov / 2.0) * self.height / self.radius, 1e-9, 1.0)
        aside = np.cross(self.ahead, self.up)
        for axis, angle in ((self.ahead, -dx * reach), (aside, -dy * reach)):
            self.up, self.ahead = rotate(self.up, axis, angle), rotate(self.ahead, axis, angle)
        self._straighten()

    def look(self, dx, dy) -> None:
        """Turn the heading and the tilt; dx, dy as in `drag`."""
        self.ahead = rotate(self.ahead, self.up, -dx * self.fov)
        untilted = self._untilted()
        self.tilt = clamp(self.tilt - dy * self.fov, -untilted, HIGHEST_LOOK - untilted)
        self._straighten()

    def zoom(self, steps) -> None:
        """Come nearer by `steps` notches of the wheel: a factor for each, not a distance."""
        self.height = clamp(self.height * WHEEL_STEP**-steps, LOWEST, HIGHEST)

    def advance(self, seconds, moves, factor=1.0) -> None:
        """Move by keys: moves = (ahead, right, up), each in -1..1, for some seconds."""
        ahead, right, up = moves
        self.drag(-right * factor * seconds, ahead * factor * seconds)
        self.zoom(-4.0 * up * factor * seconds)

    def _straighten(self):
        self.up = self.up / np.linalg.norm(self.up)
        self.ahead = self.ahead - (self.ahead @ self.up) * self.up
        self.ahead = self.ahead / np.linalg.norm(self.ahead)


@dataclass
class FlyRig:
    """A camera that flies: its speed grows with its height above the ground.

    Parameters
    ----------
    radius, ground : float, Ground
        As in OrbitRig.
    position : (3,) float
        Planet-centered [m].
    ahead : (3,) float
        Unit vector along the ground that is straight ahead.
    pitch : float
        Of the view axis above the horizontal.
    """

    radius: float
    ground: Ground
    position: np.ndarray
    ahead: np.ndarray
    pitch: float = 0.0
    fov: float = math.radians(60.0)

    def __post_init__(self):
        self.position = np.array(self.position, np.float64)
        self._settle()

    @property
    def up(self) -> np.ndarray:
        """Unit vector (3,) away from the planet's center."""
        return self.position / np.linalg.norm(self.position)

    @property
    def altitude(self) -> float:
        """Altitude of the camera [m]."""
        return float(np.linalg.norm(self.position)) - self.radius

    @property
    def height(self) -> float:
        """Height of the camera above the ground [m]."""
        return self.altitude - self.ground.altitude(self.position)

    def camera(self) -> Camera:
        """Return the camera."""
        cosine, sine = math.cos(self.pitch), math.sin(self.pitch)
        return Camera(
            position=self.position,
            forward=cosine * self.ahead + sine * self.up,
            up=cosine * self.up - sine * self.ahead,
            vertical_fov=self.fov,
        )

    def drag(self, dx, dy) -> None:
        """Look around; dx, dy = movement to the right and down in picture heights."""
        self.ahead = rotate(self.ahead, self.up, -dx * self.fov)
        self.pitch = clamp(self.pitch - dy * self.fov, -STEEPEST, STEEPEST)
        self._settle()

    look = drag

    def zoom(self, steps) -> None:
        """Narrow the picture by `steps` notches of the wheel."""
        self.fov = clamp(self.fov * WHEEL_STEP**-steps, math.radians(1.0), math.radians(120.0))

    def advance(self, seconds, moves, factor=1.0) -> None:
        """Fly by keys: moves = (ahead, right, up), each in -1..1, for some seconds."""
        if not any(moves):
            return
        ahead, right, up = moves
        axis = math.cos(self.pitch) * self.ahead + math.sin(self.pitch) * self.up
        motion = ahead * axis + right * np.cross(self.ahead, self.up) + up * self.up
        self.position = self.position + SPEED * max(self.height, SLOWEST) * factor * seconds * motion
        self._settle()

    def _settle(self):
        """Keep the camera in its range above the ground, and `ahead` along the ground."""
        up, floor = self.up, self.radius + self.ground.altitude(self.position)
        self.position = clamp(float(np.linalg.norm(self.position)), floor + LOWEST, floor + HIGHEST) * up
        self.ahead = self.ahead - (self.ahead @ up) * up
        self.ahead = self.ahead / np.linalg.norm(self.ahead)


def fly_from(rig: OrbitRig) -> FlyRig:
    """Return a flying camera with an orbiting camera's view."""
    pitch = clamp(rig.angle() - math.pi / 2.0, -STEEPEST, STEEPEST)
    return FlyRig(rig.radius, rig.ground, rig.position, rig.ahead, pitch, rig.fov)


def orbit_from(rig: FlyRig) -> OrbitRig:
    """Return an orbiting camera with a flying camera's view."""
    orbit = OrbitRig(rig.radius, rig.ground, rig.up, rig.ahead, clamp(rig.height, LOWEST, HIGHEST), 0.0, rig.fov)
    orbit.look(0.0, -(rig.pitch + math.pi / 2.0 - orbit.angle()) / orbit.fov)
    return orbit


@dataclass
class SunRig:
    """The sun as a clock and two keys move it.

    Parameters
    ----------
    direction : (3,) float
        Unit vector to the sun, in axes that turn with the planet.
    solar_day : float
        Time of one turn of the sun around the planet [s].
    """

    direction: np.ndarray
    solar_day: float = 86400.0
    elapsed: float = field(default=0.0, init=False)

    def advance(self, seconds) -> None:
        """Let time pass: the sun goes west."""
        self.elapsed += seconds
        self.direction = rotate(self.direction, (0.0, 0.0, 1.0), -2.0 * math.pi * seconds / self.solar_day)

    def turn(self, position, azimuth, elevation) -> None:
        """Add to the sun's azimuth and elevation as seen from `position` (3,)."""
        before = azimuth_elevation(position, self.direction)
        height = clamp(before[1] + elevation, -math.pi / 2.0 + 1e-3, math.pi / 2.0 - 1e-3)
        self.direction = bearing(position, before[0] + azimuth, height)


def orbit_above(planet, latitude, longitude, height) -> OrbitRig:
    """Return an orbiting camera above a place of a `World`, north at the top."""
    cosine = math.cos(latitude)
    up = np.array([cosine * math.cos(longitude), cosine * math.sin(longitude), math.sin(latitude)])
    return OrbitRig(planet.radius, planet.ground, up, local_axes(up)[1], clamp(height, LOWEST, HIGHEST))
