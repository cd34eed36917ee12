"""What keys and pointer do to a view: cameras, sun, clock, method, depth and exposure, without any window.

A window hands its events on by plain names ("w", "left", "f1", "space") and asks for the camera, scene and quality of
each frame. Everything that a key does can so be tested without a display.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from shadowatmo.observing import SkyRig
from shadowatmo.places import azimuth_elevation
from shadowatmo.quality import METHODS, as_quality
from shadowatmo.rigs import FlyRig, SunRig, clamp, fly_from, orbit_above, orbit_from
from shadowatmo.worlds import WORLDS, world

MOVES = {"w": (0, 1), "s": (0, -1), "d": (1, 1), "a": (1, -1), "e": (2, 1), "q": (2, -1)}  # key: axis, sign
SUN_KEYS = {"left": (-1, 0), "right": (1, 0), "up": (0, 1), "down": (0, -1)}
SUN_SPEED = math.radians(20.0)  # a second, while a key is down
FASTER = {"shift": 6.0, "ctrl": 1.0 / 6.0}
CLOCK = 600.0  # s of the planet's time a second, at first
EXPOSURE_STEP = 2.0**0.25
ADAPTATION = 0.5  # s in which the automatic exposure covers 63 % of a change
# depth, depth bits and the words for them, in the order of the key
DEPTHS = (("textures", 32), ("textures", 24), ("analytic", 32))

HELP = (
    ("drag, wheel", "orbit: move the ground, come nearer | fly: look around, narrow the view"),
    ("right drag", "turn and tilt; or Shift and drag"),
    ("W A S D, Q E", "move; Q down, E up; Shift faster, Ctrl slower"),
    ("Tab", "orbit or fly"),
    ("arrows", "azimuth and elevation of the sun; Shift faster, Ctrl slower"),
    ("Space , .", "run or stop the clock, slower, faster"),
    ("M  N  K", "method, depth textures, shape of the planet's shadow"),
    ("[ ]  X", "exposure, automatic exposure"),
    ("P  R", "next planet, start again"),
    ("F1 or H", "this help"),
    ("F12  Esc", "save a picture, quit"),
)


@dataclass
class Controls:
    """The state that hands move.

    Parameters
    ----------
    scene_name : str
        A world's name.
    quality : Quality or str
        Effort at first.
    cache : bool
        Whether precomputed tables are kept on disk.
    date, observer : optional
        Sun and moon are those of a time and place, as of `observing.observed`; on the planet of `scene_name` alone.

    Attributes
    ----------
    exposure : float
        Factor on radiance; follows the light while `automatic` is set.
    wants_help, wants_picture, wants_quit : bool
        For the window to act on; it clears `wants_picture` itself.
    """

    scene_name: str = "earth"
    quality: object = "balanced"
    cache: bool = True
    date: object = None
    observer: tuple[float, float, float] | None = None

    def __post_init__(self):
        self.quality = as_quality(self.quality)
        self.wants_help, self.wants_picture, self.wants_quit = True, False, False
        self.held = set()
        self.exposure, self.automatic, self._settled = 1.0, True, False
        self.running, self.clock = False, CLOCK
        self._dated = None if self.date is None else self.scene_name
        self.enter(self.scene_name)

    def enter(self, name) -> None:
        """Go to a world, to where its view begins."""
        self.world, self.scene_name = world(name), name
        self.rig = orbit_above(self.world, math.radians(15.0), math.radians(25.0), self.world.far_height)
        self.rig.tilt = -self.rig.angle()  # straight down, however small the planet is
        noon = np.array([math.cos(1.1), math.sin(1.1), 0.15])
        self.sun = SunRig(noon / np.linalg.norm(noon), self.world.solar_day)
        if name == self._dated:
            self.sun = SkyRig(self.world, self.date, self.observer)
            self.rig = self.sun.camera_rig() or self.rig
        self._settled = False

    def scene(self):
        """Return the scene of this moment."""
        return self.sun.scene() if isinstance(self.sun, SkyRig) else self.world.scene(self.sun.direction)

    def camera(self):
        """Return the camera of this moment."""
        return self.rig.camera()

    def press(self, key) -> None:
        """Take a key that went down."""
        self.held.add(key)
        action = getattr(self, f"_on_{_ACTIONS[key]}", None) if key in _ACTIONS else None
        if action is not None:
            action()

    def release(self, key) -> None:
        """Take a key that went up."""
        self.held.discard(key)

    def release_all(self) -> None:
        """Forget held keys, as when the window lost the keyboard."""
        self.held.clear()

    def drag(self, dx, dy, button="left") -> None:
        """Take a movement of the pointer with a button down, to the right and down, in picture heights."""
        (self.rig.drag if button == "left" else self.rig.look)(dx, dy)

    def wheel(self, steps) -> None:
        """Take notches of the wheel, positive away from the hand."""
        self.rig.zoom(steps)

    def advance(self, seconds) -> None:
        """Let the keys that are held, and the clock, act for a time."""
        seconds = clamp(seconds, 0.0, 0.25)  # after a stall nothing jumps
        factor = math.prod(FASTER[key] for key in FASTER if key in self.held)
        moves = [0.0, 0.0, 0.0]
        for key, (axis, sign) in MOVES.items():
            moves[axis] += sign * (key in self.held)
        self.rig.advance(seconds, moves, factor)
        turns = [sum(SUN_KEYS[key][axis] for key in SUN_KEYS if key in self.held) for axis in (0, 1)]
        if any(turns):
            azimuth, elevation = (turn * SUN_SPEED * factor * seconds for turn in turns)
            self.sun.turn(self.rig.position, azimuth, elevation)
        if self.running:
            self.sun.advance(self.clock * seconds)

    def adapt(self, exposure, seconds) -> None:
        """Follow the exposure that a meter found, slowly; the first one is taken at once."""
        if not self.automatic or not exposure > 0.0:
            return
        share = 1.0 - math.exp(-seconds / ADAPTATION) if self._settled else 1.0
        self.exposure *= (exposure / self.exposure) ** share
        self._settled = True

    def status(self) -> str:
        """Return one line about the moment, for the title of a window."""
        azimuth, elevation = azimuth_elevation(self.rig.position, self.sun.direction)
        kind = "fly" if isinstance(self.rig, FlyRig) else "orbit"
        depth = "analytic" if self.quality.depth == "analytic" else f"{self.quality.depth_bits}-bit depth"
        parts = (
            f"{self.scene_name}, {kind}",
            f"{distance(self.rig.height)} above ground",
            f"sun {math.degrees(azimuth):.0f}°, {math.degrees(elevation):+.1f}°",
            *([f"{self.sun.moment:%Y-%m-%d %H:%M:%S} UTC"] if isinstance(self.sun, SkyRig) else []),
            f"clock {f'x{self.clock:g}' if self.running else 'stopped'}",
            f"{self.quality.method}, {depth}, {self.quality.shadow}",
            f"exposure {self.exposure:.3g}{' auto' if self.automatic else ''}",
        )
        return " | ".join(parts)

    def _on_camera(self):
        self.rig = orbit_from(self.rig) if isinstance(self.rig, FlyRig) else fly_from(self.rig)

    def _on_clock(self):
        self.running = not self.running

    def _on_slower(self):
        self.clock = max(self.clock / 2.0, 1.0)

    def _on_faster(self):
        self.clock = min(self.clock * 2.0, 86400.0)

    def _on_method(self):
        self.quality = replace(self.quality, method=_next(METHODS, self.quality.method))

    def _on_depth(self):
        depth, bits = _next(DEPTHS, (self.quality.depth, self.quality.depth_bits))
        self.quality = replace(self.quality, depth=depth, depth_bits=bits)

    def _on_shadow(self):
        self.quality = replace(self.quality, shadow=_next(("cylinder", "cone"), self.quality.shadow))

    def _on_darker(self):
        self._expose(1.0 / EXPOSURE_STEP)

    def _on_brighter(self):
        self._expose(EXPOSURE_STEP)

    def _expose(self, factor):
        self.automatic = False
        self.exposure = clamp(self.exposure * factor, 1e-6, 1e9)

    def _on_automatic(self):
        self.automatic = not self.automatic

    def _on_planet(self):
        self.enter(_next(tuple(WORLDS), self.scene_name))

    def _on_again(self):
        self.enter(self.scene_name)

    def _on_help(self):
        self.wants_help = not self.wants_help

    def _on_picture(self):
        self.wants_picture = True

    def _on_quit(self):
        self.wants_quit = True


_ACTIONS = {
    "tab": "camera", "space": "clock", "comma": "slower", "period": "faster", "m": "method", "n": "depth",
    "k": "shadow", "left_bracket": "darker", "right_bracket": "brighter", "x": "automatic", "p": "planet",
    "r": "again", "f1": "help", "h": "help", "f12": "picture", "escape": "quit",
}  # fmt: skip
KEYS = (*MOVES, *SUN_KEYS, *FASTER, *_ACTIONS)  # every name that means something
WINDOW_NAMES = {"shift": ("LEFT_SHIFT", "RIGHT_SHIFT"), "ctrl": ("LEFT_CTRL",)}  # where upper case is not all


def key_names(keys) -> dict:
    """Return our names of keys by the codes of moderngl-window's key constants, where a backend has them."""
    names = {}
    for name in KEYS:
        for attribute in WINDOW_NAMES.get(name, (name.upper(),)):
            code = getattr(keys, attribute, "undefined")
            if code != "undefined":
                names[code] = name
    return names


def _next(row, value):
    """Return the member of a row that follows `value`; the first one after the last, or where it is none of them."""
    return row[(row.index(value) + 1) % len(row)] if value in row else row[0]


def distance(metres) -> str:
    """Return a length in the unit that suits it."""
    if metres < 1e3:
        return f"{metres:.1f} m" if metres < 100.0 else f"{metres:.0f} m"
    return f"{metres / 1e3:.1f} km" if metres < 1e6 else f"{metres / 1e3:,.0f} km".replace(",", " ")
