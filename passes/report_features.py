"""What each feature of a scene costs alone, on top of a bare scene: one sun over molecules, single scattering."""

from dataclasses import dataclass, replace

import numpy as np

from shadowatmo.parameters import Atmosphere, Occluder, Sun
from shadowatmo.passes.clock import ratio, ratio_noise
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.presets import EARTH
from shadowatmo.quality import Quality
from shadowatmo.report_rays import CAMERAS, SUN
from shadowatmo.scene import Scene
from shadowatmo.surface import Surface

BARE_AIR = replace(EARTH, ozone=None, mie_scattering=(0.0,) * 3, mie_extinction=(0.0,) * 3)
BARE = Scene(BARE_AIR, SUN)
SINGLE = Quality(depth="analytic", orders=1)
ALL = replace(SINGLE, orders="all")
MOON_DISTANCE, MOON_RADIUS = 3.80e8, 1.7374e6  # m
TERRAIN = 2e4  # m, to the host's wall


@dataclass(frozen=True)
class Feature:
    """A scene with one thing more than another.

    Parameters
    ----------
    name : str
    scene, quality : Scene, Quality
    base : str
        Name of the feature whose cost is taken away.
    unused : bool
        Whether the scene names the thing and yet does not need it, so that it has to cost nothing.
    composed : bool
        Whether a host's depth ends the rays.
    """

    name: str
    scene: Scene = BARE
    quality: Quality = SINGLE
    base: str = "bare"
    unused: bool = False
    composed: bool = False


def features() -> tuple[Feature, ...]:
    """Return the bare scene first, then each feature alone."""
    eye = np.array(next(iter(CAMERAS.values())).position)
    toward, aside = np.array(SUN.direction), np.array([0.0, 0.0, 1.0])
    moons = {
        name: Occluder(tuple(MOON_DISTANCE * toward + eye + distance * aside), MOON_RADIUS)
        for name, distance in (("near", 2e6), ("far", 1e9))
    }
    other = Sun(direction=(0.8, 0.5, 0.3), irradiance=(0.5, 0.4, 0.3))

    def air(**changes) -> Atmosphere:
        return replace(BARE_AIR, **changes)

    aerosols = {"mie_scattering": EARTH.mie_scattering, "mie_extinction": EARTH.mie_extinction}
    return (
        Feature("bare"),
        Feature("aerosols", replace(BARE, atmosphere=air(**aerosols))),
        Feature("ozone", replace(BARE, atmosphere=air(ozone=EARTH.ozone))),
        Feature("ozone of no density", replace(BARE, atmosphere=air(ozone=_no_ozone())), unused=True),
        Feature("multiple scattering", quality=ALL),
        Feature("eclipse", replace(BARE, occluders=moons["near"])),
        Feature("a moon that shades no air", replace(BARE, occluders=moons["far"]), unused=True),
        Feature("second sun", replace(BARE, suns=(SUN, other))),
        Feature("sun's disc in view", replace(BARE, sun_disc=True)),
        Feature("finite disc at the terminator", replace(BARE, suns=replace(SUN, disc_at_terminator=True))),
        Feature("lit ground", replace(BARE, surface=Surface())),
        Feature("skylight on the ground", replace(BARE, surface=Surface()), ALL, "lit ground"),
        Feature("relief and sea", replace(BARE, surface=Surface.earth()), SINGLE, "lit ground"),
        Feature("terrain cut by a host's depth", composed=True),
        Feature("depth textures", quality=replace(SINGLE, depth="textures")),
    )


def _no_ozone():
    return replace(EARTH.ozone, extinction=(0.0, 0.0, 0.0))


class FeatureBench:
    """Times features with one camera, round by round, so that a busy spell strikes all alike.

    Parameters
    ----------
    ctx : moderngl.Context
    clock : Clock
    size : (int, int)
    cache : TableCache
    """

    def __init__(self, ctx, clock, size, cache):
        self.ctx, self.clock, self.size, self.cache = ctx, clock, size, cache
        self.camera = next(iter(CAMERAS.values()))
        self._pairs = {}

    def time(self, feature, frames) -> None:
        """Time some frames of a feature, beside what was timed before."""
        with Renderer(self.ctx, feature.scene, self.size, feature.quality, cache=self.cache) as renderer:
            host = self._host() if feature.composed else None

            def draw():
                return renderer.render(self.camera) if host is None else renderer.compose(*host, self.camera)

            draw()  # compiles, and fetches the tables
            self._pairs.setdefault(feature.name, []).extend(self.clock.pairs(draw, frames))
            for texture in host or ():
                texture.release()

    def _host(self):
        """Return a host's color and distances [m]: the lower half of the picture is a wall."""
        width, height = self.size
        depth = np.full((height, width), np.inf, np.float32)
        depth[: height // 2] = TERRAIN
        color = self.ctx.texture(self.size, 4, np.zeros((height, width, 4), np.float32).tobytes(), dtype="f4")
        return color, self.ctx.texture(self.size, 1, depth.tobytes(), dtype="f4")

    def table(self, wanted) -> list[dict]:
        """Return name, cost in all, cost on top of its base, and their noise, in copies, of each feature."""
        pairs = {name: np.array(p) for name, p in self._pairs.items()}
        costs, noise = ({name: f(p) for name, p in pairs.items()} for f in (ratio, ratio_noise))
        rows = []
        for feature in wanted:
            cost = costs[feature.name]
            extra = cost if feature.name == "bare" else cost - costs[feature.base]
            row = {"name": feature.name, "base": feature.base, "unused": feature.unused, "cost": cost, "extra": extra}
            rows.append({**row, "noise": float(np.hypot(noise[feature.name], noise[feature.base]))})
        return rows
