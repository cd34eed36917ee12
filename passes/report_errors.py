"""Errors of the candidates: by probe on sets of rays, by frames at sampled pixels, against the float64 twin.

The twin has no multiple scattering; its truth is the solver's own at a much finer recipe, gathered by more nodes.
"""

from dataclasses import dataclass, replace

import numpy as np

from shadowatmo import reference
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.atmosphere import published_color
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.probe import multiple_scattering, probe
from shadowatmo.passes.table_probe import release_probe_tables
from shadowatmo.quality import PATH_METHODS, Quality
from shadowatmo.report_errors import budget_errors, ray_errors, statistics
from shadowatmo.scene import Scene

TRUTH_OF_MULTIPLE = Quality(nodes=10, gap_nodes=10, terms=6, multiple="truth")  # 16 nodes change 5e-4 of it
APART = {"depth": "analytic", "depth_bits": 32, "tolerance": 0.0, "multiple": "balanced"}  # no matter to single rays
GATHER = {"nodes": 8, "gap_nodes": 6}  # of probes for multiple scattering: the recipe decides


@dataclass(frozen=True, eq=False)
class Truth:
    """Of the rays of one scene: single and multiple scattering, transmittance (N, 3); multiple is None in eclipses."""

    single: np.ndarray
    multiple: np.ndarray | None
    transmittance: np.ndarray

    def light(self, orders) -> np.ndarray:
        """Return the light that `orders` stands for."""
        return self.single if orders == 1 or self.multiple is None else self.single + self.multiple


def true_light(ctx, shot, multiple=True) -> Truth:
    """Return the truth of the rays of a Shot; without `multiple` that of single scattering alone."""
    rays = shot.origins, shot.directions, shot.t_max
    twin = reference.probe(shot.scene, *rays)
    wanted = multiple and not shot.scene.occluders
    more = probe(ctx, shot.scene, *rays, quality=TRUTH_OF_MULTIPLE).multiple if wanted else None
    return Truth(twin.single, more, twin.transmittance)


class ProbeErrors:
    """Judges candidates by the same rays, scene by scene; what several share is probed once.

    Parameters
    ----------
    ctx : moderngl.Context
    sets : sequence of RaySet
    """

    def __init__(self, ctx, sets):
        self.ctx, self.sets = ctx, sets
        self._truth, self._found, self._multiple, self._counted = {}, {}, {}, {}

    def prepare(self, ray_set, multiple=True) -> None:
        """Work out the truth of a set, or without `multiple` of its single scattering alone."""
        for shot in ray_set.shots:
            self._truth[shot] = true_light(self.ctx, shot, multiple)

    def judge(self, quality, ray_set) -> dict:
        """Return the statistics of a candidate in a set: of its light by orders, against the maximum, of transmittance.

        What budgets count is kept for `budget`.
        """
        found = {name: [] for name in ("single", "all", "frame", "transmittance")}
        counted = self._counted.setdefault(quality, {1: [], "all": []})
        for shot in ray_set.shots:
            truth = self._truth[shot]
            single, multiple, transmittance = self._light(quality, shot, truth.multiple is not None)
            clear = np.abs(transmittance - truth.transmittance).max(axis=1)
            alone, _ = ray_errors(single, truth.light(1))
            every, frame = ray_errors(single + multiple if truth.multiple is not None else single, truth.light("all"))
            found["single"].append(alone)
            found["all"].append(every)
            found["frame"].append(frame)
            found["transmittance"].append(clear)
            counted[1].append(budget_errors(alone, clear))
            counted["all"].append(budget_errors(every, clear))
        return {name: statistics(np.concatenate(parts)) for name, parts in found.items()}

    def counted(self, quality, orders) -> np.ndarray:
        """Return what budgets count of a candidate's rays, in all sets judged (N,)."""
        return np.concatenate(self._counted[quality][orders])

    def budget(self, quality) -> dict:
        """Return the statistics of `counted` by orders."""
        return {name: statistics(self.counted(quality, orders)) for name, orders in (("single", 1), ("all", "all"))}

    def _light(self, quality, shot, with_multiple):
        """Return single, multiple (0 where not asked for) and transmittance (N, 3) of a candidate."""
        rays = shot.origins, shot.directions, shot.t_max
        if quality.method == "widths":
            return self._widths(shot, rays)
        if quality.method in PATH_METHODS:
            alone = self._probed(replace(quality, orders=1), shot, rays)
            none = np.zeros_like(alone.single)
            more = self._path_multiple(quality.multiple, shot, rays) if with_multiple else none
            return alone.single, more, alone.transmittance
        light = self._probed(quality, shot, rays)
        return light.single, light.multiple, light.transmittance

    def _probed(self, quality, shot, rays):
        key = replace(quality, **APART), shot
        if key not in self._found:
            self._found[key] = probe(self.ctx, shot.scene, *rays, quality=key[0])
        return self._found[key]

    def _path_multiple(self, recipe, shot, rays):
        key = recipe, shot
        if key not in self._multiple:
            quality = Quality(multiple=recipe, **GATHER)
            self._multiple[key] = probe(self.ctx, shot.scene, *rays, quality=quality).multiple
        return self._multiple[key]

    def _widths(self, shot, rays):
        """Return what path_widths.glsl makes of the lengths; its range depends on where the eye is."""
        lengths = reference.lengths(shot.scene, *rays)
        radius, top = np.linalg.norm(shot.origins, axis=1), shot.scene.atmosphere.top_radius
        span = radius + top - np.maximum(radius - top, 0.0)
        brightness = (3.0 * (lengths.lit + 0.2 * lengths.shadow) / span)[:, None]
        *color, opacity = published_color(shot.scene.atmosphere)
        clear = 1.0 - opacity * np.clip(brightness, 0.0, 1.0)
        return brightness * color, np.zeros((len(radius), 3)), np.broadcast_to(clear, (len(radius), 3))

    def release(self) -> None:
        """Release the tables that the probes kept."""
        release_probe_tables(self.ctx)
        for recipe in RECIPES:
            multiple_scattering(self.ctx, recipe).release()


class FrameErrors:
    """Judges whole frames at sampled pixels: passes, depth textures and what pixels share included.

    Parameters
    ----------
    ctx : moderngl.Context
    cameras : dict of str to Camera
    size : (int, int)
        Of the frames [pixels].
    scene : Scene
        Without a surface: its frames hold the light of the air alone.
    pixels : int
        Sampled from each frame.
    seed : int
    """

    def __init__(self, ctx, cameras, size, scene, pixels, seed):
        self.ctx, self.cameras, self.size, self.scene = ctx, cameras, size, scene
        rng = np.random.default_rng(seed)
        self._pixels = rng.choice(size[0] * size[1], min(pixels, size[0] * size[1]), replace=False)
        self._truth, self._counted = {}, {}

    def truth(self, name) -> Truth:
        """Return the truth of a camera's pixels."""
        if name not in self._truth:
            camera = self.cameras[name]
            directions = camera.pixel_rays(self.size).reshape(-1, 3)[self._pixels]
            self._truth[name] = frame_truth(self.ctx, self.scene, camera, directions)
        return self._truth[name]

    def judge(self, frame, name, quality) -> dict:
        """Return the statistics of a quality's frame: its light, and against the frame's maximum."""
        light = frame.numpy().reshape(-1, 3)[self._pixels].astype(np.float64)
        relative, against = ray_errors(light, self.truth(name).light(quality.orders))
        self._counted.setdefault(quality, []).append(relative)
        return {"all": statistics(relative), "frame": statistics(against)}

    def budget(self, quality) -> dict:
        """Return the statistics of a quality's pixels in all frames judged."""
        return statistics(np.concatenate(self._counted[quality]))


def frame_truth(ctx, scene, camera, directions) -> Truth:
    """Return the truth of a camera's rays (N, 3)."""
    origins = np.broadcast_to(camera.position, directions.shape)
    twin = reference.probe(scene, origins, directions)
    multiple = probe(ctx, scene, origins, directions, quality=TRUTH_OF_MULTIPLE).multiple
    return Truth(twin.single, multiple, twin.transmittance)


def error_map(ctx, scene, camera, quality, size, stride) -> np.ndarray:
    """Return relative errors (rows, columns) of a frame at every `stride`-th pixel, nan where too dark to judge."""
    with Renderer(ctx, scene, size, quality) as renderer:
        light = renderer.render(camera).numpy()[stride // 2 :: stride, stride // 2 :: stride]
    directions = camera.pixel_rays(size)[stride // 2 :: stride, stride // 2 :: stride]
    truth = frame_truth(ctx, scene, camera, directions.reshape(-1, 3)).light(quality.orders)
    return ray_errors(light.reshape(-1, 3).astype(np.float64), truth)[0].reshape(light.shape[:2])


def report_scene(sun) -> Scene:
    """Return the scene of the report's frames: the Earth's air over a black ground."""
    return Scene(suns=sun)
