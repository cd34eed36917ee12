"""One run of the report: errors, costs, tables, memory and cold starts of every candidate on this machine."""

import gc
import os
import platform
import tempfile

import moderngl
import numpy as np

import shadowatmo
from shadowatmo.cache import TableCache
from shadowatmo.candidates import candidates, changed_fields
from shadowatmo.passes.clock import Clock, ratio
from shadowatmo.passes.cold_start import cold_start
from shadowatmo.passes.gl.context import describe_context
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.report_errors import FrameErrors, ProbeErrors, report_scene
from shadowatmo.passes.report_features import FeatureBench, features
from shadowatmo.quality import NAMED, PATH_METHODS
from shadowatmo.report import FORMAT, VERSION, Options
from shadowatmo.report_rays import CAMERAS, KINDS, SUN, ray_set

FAST_CAMERAS = 2
OTHER_PLANETS = ("Mars", "toy planet", "dense air")  # tables and shaders of their own
LONG = 30.0  # copies
TABLE_SOLVES = 3
BYTES = {"f1": 1, "f2": 2, "f4": 4, "nu1": 1, "u1": 1}


class Report:
    """Measures, and returns what it found as plain data.

    Parameters
    ----------
    ctx : moderngl.Context
    options : Options
    progress : callable, optional
        Called as progress(label, done, total).
    wanted : dict of str to Quality, optional
        The candidates; those of `candidates` without it.
    """

    def __init__(self, ctx, options=None, progress=None, wanted=None):
        self.ctx, self.options = ctx, options or Options()
        self._progress = progress or (lambda *_: None)
        self.wanted = candidates(self.options.fast) if wanted is None else wanted
        cameras = list(CAMERAS.items())[: FAST_CAMERAS if self.options.fast else None]
        self.cameras = dict(cameras)
        self.scene = report_scene(SUN)
        self._done, self._total = 0, 1

    def run(self, cold=True) -> dict:
        """Measure and return the report, without the cold starts if so wanted."""
        options, kinds = self.options, [k for k in KINDS if not (self.options.fast and k.name in OTHER_PLANETS)]
        sets = [ray_set(kind, options.rays, options.seed) for kind in kinds]
        wanted_features = features()
        rounds = options.rounds * (len(self.wanted) + len(wanted_features))
        self._total = rounds + len(self.wanted) + len(sets) + 1 + len(self._cold_names()) * cold
        found = {name: {"name": name, "fields": changed_fields(quality), "errors": {}, "frames": {}}
                 for name, quality in self.wanted.items()}  # fmt: skip
        self._judge_rays(found, sets)
        with tempfile.TemporaryDirectory() as folder:
            cache, clock = TableCache(folder), Clock(self.ctx, options.size)
            self._judge_frames(found, clock, cache)
            table = self._time(found, clock, cache, wanted_features)
            machine = self._machine(clock)
            clock.release()
        for name in self._cold_names() if cold else ():
            found[name]["cold_start"] = cold_start(found[name]["fields"], options.size)
            self._step("cold starts")
        return {"format": FORMAT, "version": VERSION, "shadowatmo": shadowatmo.__version__, "machine": machine,
                "options": options.plain(), "candidates": list(found.values()), "features": table}  # fmt: skip

    def _step(self, label):
        self._done += 1
        self._progress(label, self._done, self._total)

    def _machine(self, clock) -> dict:
        about = describe_context(self.ctx)
        copy = float(np.median(clock.copies))
        return {"renderer": about["renderer"], "version": about["version"], "clock": clock.name, "copy_seconds": copy,
                "python": platform.python_version(), "system": platform.system(), "cores": os.cpu_count()}  # fmt: skip

    def _judge_rays(self, found, sets):
        """Probe every candidate on every set of rays."""
        probes = ProbeErrors(self.ctx, sets)
        for rays in sets:
            probes.prepare(rays)
            for name, quality in self.wanted.items():
                found[name]["errors"][rays.name] = probes.judge(quality, rays)
            self._step(f"errors: {rays.name}")
        for name, quality in self.wanted.items():
            found[name]["budget"] = probes.budget(quality)
        probes.release()

    def _judge_frames(self, found, clock, cache):
        """Compute tables, weigh the textures, and judge a frame of each camera."""
        options = self.options
        judge = FrameErrors(self.ctx, self.cameras, options.size, self.scene, options.pixels, options.seed)
        for name in self.cameras:
            judge.truth(name)
        self._step("errors: frames")
        tables = {}
        for name, quality in self.wanted.items():
            if _tables_of(quality) not in tables:
                tables[_tables_of(quality)] = self._table_cost(quality, clock, cache)
            found[name]["table_cost"] = tables[_tables_of(quality)]
            before = texture_bytes()
            with Renderer(self.ctx, self.scene, self.options.size, quality, cache=cache) as renderer:
                for camera_name, camera in self.cameras.items():
                    frame = renderer.render(camera)
                    found[name]["frames"][camera_name] = judge.judge(frame, camera_name, quality)
                found[name]["memory"] = texture_bytes() - before
            found[name].setdefault("budget", {})["frames"] = judge.budget(quality)
            self._step(f"frames: {name}")

    def _table_cost(self, quality, clock, cache) -> float:
        """Return what the tables of a quality cost to compute [copies]: a first frame less a second."""
        if _tables_of(quality) == ():
            return 0.0
        camera = next(iter(self.cameras.values()))
        costs = []
        # the first one compiles the shaders, and keeps the tables for the frames to come
        for kept in (cache, *(1 if self.options.fast else TABLE_SOLVES) * (False,)):
            with Renderer(self.ctx, self.scene, self.options.size, quality, cache=kept) as renderer:
                draw = _drawing(renderer, camera)
                first, frame = clock.seconds(draw), clock.seconds(draw)
                costs.append((max(first - frame, 0.0), np.median([clock.copy() for _ in range(3)])))
        return ratio(np.array(costs[1:]))

    def _time(self, found, clock, cache, wanted_features) -> list[dict]:
        """Time all candidates and features round by round; return the table of features."""
        bench = FeatureBench(self.ctx, clock, self.options.size, cache)
        pairs = {name: {camera: [] for camera in self.cameras} for name in self.wanted}
        for number in range(self.options.rounds):
            turn = 1 if number % 2 == 0 else -1  # there and back: what drifts, drifts for both ends
            for name, quality in list(self.wanted.items())[::turn]:
                with Renderer(self.ctx, self.scene, self.options.size, quality, cache=cache) as renderer:
                    for camera_name, camera in self.cameras.items():
                        renderer.render(camera)
                        pairs[name][camera_name].extend(self._pairs(clock, _drawing(renderer, camera)))
                self._step(f"cost, round {number + 1}")
            for feature in wanted_features[::turn]:
                bench.time(feature, self.options.frames)
                self._step(f"features, round {number + 1}")
        for name in self.wanted:
            found[name]["cost"] = {camera: ratio(np.array(p)) for camera, p in pairs[name].items()}
        return bench.table(wanted_features)

    def _pairs(self, clock, draw) -> np.ndarray:
        """Return the pairs of one round; a frame that takes LONG is disturbed little, and timed once."""
        first = clock.pairs(draw, 1)
        more = self.options.frames - 1 if ratio(first) < LONG else 0
        return np.concatenate([first, clock.pairs(draw, more)]) if more else first

    def _cold_names(self) -> list[str]:
        """Return the candidates that are also started cold: presets and the first one of each method, or one."""
        if self.options.fast:
            return ["balanced"] if "balanced" in self.wanted else []
        names, methods = [name for name in self.wanted if name in NAMED], set()
        for name, quality in self.wanted.items():
            if quality.method not in methods and name not in NAMED:
                names.append(name)
                methods.add(quality.method)
        return names


def _drawing(renderer, camera):
    return lambda: renderer.render(camera)


def _tables_of(quality) -> tuple:
    """Return what tells the tables of qualities apart; empty for those without."""
    columns = ("columns",) if quality.column_table else ()
    if quality.method in PATH_METHODS:
        return (*columns, quality.multiple)
    return () if quality.method == "widths" else (*columns, quality.method)


def texture_bytes() -> int:
    """Return the bytes of all textures that are alive, as their formats say."""
    gc.collect()
    total = 0
    for thing in gc.get_objects():
        if isinstance(thing, moderngl.Texture) and hasattr(thing.mglo, "use"):  # not released
            texel = 4 if thing.depth else thing.components * BYTES.get(thing.dtype, 4)
            total += thing.width * thing.height * texel
    return total
