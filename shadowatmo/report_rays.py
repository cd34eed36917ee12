"""The rays and cameras that the report judges every method with: the same for all, fixed and seeded.

A set is a kind of situation: where the eye is, how high the sun stands, what ends the rays. Half of its rays come from
a fixed lattice (an additive recurrence, the same in every run), half from a seeded generator. One scene has one sun, so
a set is a handful of scenes with their rays.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.parameters import Atmosphere, Occluder, Sun
from shadowatmo.presets import DENSE_EARTH, EARTH, MARS, TOY_PLANET
from shadowatmo.scene import Scene

SEED = 20261122
AXES = 7  # random numbers of a ray
MOON_DISTANCE, MOON_RADIUS = 3.80e8, 1.7374e6  # m: a large moon, so that the umbra reaches the ground


@dataclass(frozen=True)
class Kind:
    """How the rays of a set are drawn.

    Parameters
    ----------
    name : str
        Of the set.
    zeniths : (float, float)
        Range of the sun's zenith angle below the eye [degrees].
    altitudes : (float, float)
        Range of the eye's altitude on the Earth [m], drawn uniformly in its logarithm; elsewhere in proportion to the
        thickness of the air.
    atmosphere : Atmosphere
    cut : (float, float), optional
        Range of t_max [m], drawn uniformly in its logarithm.
    moon : bool
        A moon's penumbra lies over the eye.
    aim : str
        "around": half of the rays within 10 degrees of the horizontal; "limb": rays that pass above the ground;
        "planet": anything between the center and the top of the air. An eye above the air aims at the planet always.
    """

    name: str
    zeniths: tuple[float, float]
    altitudes: tuple[float, float] = (1.0, 1e4)
    atmosphere: Atmosphere = EARTH
    cut: tuple[float, float] | None = None
    moon: bool = False
    aim: str = "around"


KINDS = (
    Kind("ground, day", (0.0, 85.0)),
    Kind("ground, low sun", (85.0, 93.0)),
    Kind("ground, deep twilight", (93.0, 102.0)),
    Kind("terrain 1 to 300 km", (0.0, 92.0), (1.0, 3e3), cut=(1e3, 3e5)),
    Kind("ground to space", (0.0, 100.0), (1.0, 4e8), aim="planet"),
    Kind("limb", (0.0, 110.0), (1e5, 4e7), aim="limb"),
    Kind("eclipse", (0.0, 80.0), moon=True),
    Kind("Mars", (0.0, 96.0), (1.0, 4e6), MARS, aim="planet"),
    Kind("toy planet", (0.0, 100.0), (1.0, 4e6), TOY_PLANET, aim="planet"),
    Kind("dense air", (0.0, 94.0), (1.0, 4e6), DENSE_EARTH, aim="planet"),
)


@dataclass(frozen=True, eq=False)
class Shot:
    """Rays in one scene: origins, directions (N, 3), t_max (N,)."""

    scene: Scene
    origins: np.ndarray
    directions: np.ndarray
    t_max: np.ndarray


@dataclass(frozen=True, eq=False)
class RaySet:
    """A kind of situation and its rays."""

    kind: Kind
    shots: tuple[Shot, ...]

    @property
    def name(self) -> str:
        return self.kind.name

    def __len__(self) -> int:
        return sum(len(shot.origins) for shot in self.shots)


def ray_set(kind, count, seed=SEED, suns=6, lattice=True) -> RaySet:
    """Return a set of `count` rays, shared out among `suns` scenes.

    Parameters
    ----------
    kind : Kind
    count, suns : int
        Rays in all, and scenes, > 0.
    seed : int
        Of the random half.
    lattice : bool
        Whether half of the rays are the fixed ones; False: all are drawn.
    """
    rng = np.random.default_rng([seed, sum(map(ord, kind.name))])
    shots = []
    for number in range(suns):
        rays = max(count // suns, 2)
        fixed = rays // 2 if lattice else 0
        u = np.concatenate([_lattice(fixed, 1 + number * fixed), rng.random((rays - fixed, AXES))])
        fraction = (number + 0.5) / suns if lattice and number % 2 == 0 else (number + rng.random()) / suns
        zenith = kind.zeniths[0] + fraction * (kind.zeniths[1] - kind.zeniths[0])
        shots.append(_shot(kind, u, math.radians(zenith), rng.random(2)))
    return RaySet(kind, tuple(shots))


def _lattice(count, first):
    """Return (count, AXES) numbers of the additive recurrence by powers of the root of x^(d + 1) = x + 1."""
    root = 1.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (AXES + 1))
    steps = root ** -np.arange(1.0, AXES + 1)
    return (0.5 + (first + np.arange(count))[:, None] * steps) % 1.0


def _shot(kind, u, zenith, offset) -> Shot:
    """Return the rays of numbers u (N, AXES) under a sun at `zenith` [rad]; the eye is on the z axis."""
    atmosphere = kind.atmosphere
    bottom, top = atmosphere.bottom_radius, atmosphere.top_radius
    scale = atmosphere.thickness / EARTH.thickness
    altitude = scale * _log_range(kind.altitudes, u[:, 0])
    r = bottom + altitude
    nearest = r >= top  # of the eyes, those that only see air where they aim at the planet
    level = np.where(u[:, 1] < 0.5, 20.0 * u[:, 2] - 10.0, 180.0 * u[:, 2] - 90.0)
    mu = np.sin(np.radians(level))
    impact = top * np.sqrt(u[:, 2])
    if kind.aim == "limb":
        impact = bottom + atmosphere.thickness * (0.01 + 0.8 * u[:, 2])
    aimed = nearest if kind.aim != "limb" else np.ones(len(u), bool)
    mu = np.where(aimed, -np.sqrt(np.maximum(1.0 - np.minimum(impact / r, 1.0) ** 2, 0.0)), mu)
    azimuth = 2.0 * np.pi * u[:, 3]
    sine = np.sqrt(1.0 - mu * mu)
    directions = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), mu], axis=1)
    origins = r[:, None] * np.array([0.0, 0.0, 1.0])
    t_max = np.full(len(u), np.inf) if kind.cut is None else scale * _log_range(kind.cut, u[:, 4])
    toward = np.array([math.sin(zenith), 0.0, math.cos(zenith)])
    sun = Sun(direction=tuple(toward))
    return Shot(Scene(atmosphere, sun, _moons(kind, toward, offset)), origins, directions, t_max)


def _moons(kind, toward, offset):
    """Return the moon whose shadow's axis passes within 2500 km of the eye, the closer the more often."""
    if not kind.moon:
        return ()
    across = np.array([toward[2], 0.0, -toward[0]])
    distance, angle = 2.5e6 * offset[0] ** 2, 2.0 * math.pi * offset[1]
    aside = distance * (math.cos(angle) * across + math.sin(angle) * np.array([0.0, 1.0, 0.0]))
    center = MOON_DISTANCE * toward + np.array([0.0, 0.0, kind.atmosphere.bottom_radius]) + aside
    return (Occluder(tuple(center), MOON_RADIUS),)


def _log_range(limits, u):
    low, high = np.log(limits)
    return np.exp(low + (high - low) * u)


# --- cameras: whole frames, because depth textures and what is shared among pixels are not in single rays

SUN = Sun(direction=(1.0, 0.0, 0.0))


def _level(zenith, altitude, azimuth, elevation, fov=60.0) -> Camera:
    """Return a camera where the sun stands at `zenith`, turned by `azimuth` from it and `elevation` from the level."""
    z, a, e = np.radians([zenith, azimuth, elevation])
    up = np.array([math.cos(z), math.sin(z), 0.0])
    sunward, aside = np.array([up[1], -up[0], 0.0]), np.array([0.0, 0.0, 1.0])
    forward = math.cos(e) * (math.cos(a) * sunward + math.sin(a) * aside) + math.sin(e) * up
    position = (EARTH.bottom_radius + altitude) * up
    return Camera(position=tuple(position), forward=tuple(forward), up=tuple(up), vertical_fov=math.radians(fov))


CAMERAS = {
    "2 m, sunset": _level(88.0, 2.0, 20.0, 5.0),
    "400 km, day": _level(60.0, 4e5, 0.0, -22.0),
    "2 m, twilight, away from the sun": _level(93.0, 2.0, 170.0, 10.0),
    "10 km, low sun": _level(80.0, 1e4, 0.0, -8.0),
    "400 km, sunset": _level(104.0, 4e5, 0.0, -18.0),
    "20 000 km, half phase": Camera(
        position=(1.897e6, 1.897e7, 5.691e6), target=(0.0, 0.0, 0.0), vertical_fov=math.radians(45.0)
    ),
}
