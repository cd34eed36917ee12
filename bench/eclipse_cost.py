"""What moons cost a frame: CPU-time ratios to a full-screen copy pass, the variants interleaved in one run.

Usage: python bench/eclipse_cost.py [frames]. Reads as bench/frame_cost.py does. Every row is one camera, every column a
set of moons.
"""

import itertools
import sys
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import shadowatmo as sa  # noqa: E402
from bench.frame_cost import SIZE  # noqa: E402
from shadowatmo.passes.clock import Clock  # noqa: E402
from tests.cameras import CAMERAS, SUN  # noqa: E402

NAMES = ("2 m, sunset", "2 m, noon", "400 km, day", "20 000 km, half phase")
MOON = sa.Occluder(center=(3.66e8, 3.0e6, 1.0e6), radius=1.7374e6)
SECOND = sa.Occluder(center=(4.2e8, 3.0e6, 2.2e6), radius=1.9e6)
AWAY = tuple(sa.Occluder(center=(3.66e8, 5e7 * np.cos(a), 5e7 * np.sin(a)), radius=1.7e6) for a in range(8))
VARIANTS = {"no moon": (), "eight that miss": AWAY, "one": (MOON,), "two, overlapping": (MOON, SECOND)}
SURFACES = {"air alone": None, "plain ground": sa.Surface()}
QUALITIES = {"balanced": "balanced", "every pixel": sa.Quality(depth="analytic")}


def main(frames=9):
    ctx = sa.open_context()
    clock = Clock(ctx, SIZE)
    for (title, surface), (effort, quality) in itertools.product(SURFACES.items(), QUALITIES.items()):
        print(f"{title + ', ' + effort:26s}" + "".join(f"{name:>18s}" for name in VARIANTS))
        scenes = [sa.Scene(suns=SUN, occluders=moons, surface=surface) for moons in VARIANTS.values()]
        renderers = [sa.Renderer(ctx, scene, SIZE, quality) for scene in scenes]
        for name in NAMES:
            draws = [partial(renderer.render, CAMERAS[name]) for renderer in renderers]
            for draw in draws:
                draw()
            times = np.array([[clock.copy(), *(clock.seconds(draw) for draw in draws)] for _ in range(frames)])
            costs = np.median(times, axis=0)[1:] / np.median(times[:, 0])
            print(f"{name:26s}" + "".join(f"{cost:18.2f}" for cost in costs), flush=True)
        for renderer in renderers:
            renderer.close()


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:]))
