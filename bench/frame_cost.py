"""Cost of whole frames as ratios to a full-screen copy pass, interleaved in one run.

Usage: python bench/frame_cost.py [frames]. CPU time where the renderer runs on the CPU (llvmpipe): it holds on a busy
machine where wall time does not; timer queries on hardware. `shadowatmo report` measures errors beside it.
"""

import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import shadowatmo as sa  # noqa: E402
from shadowatmo.passes.clock import Clock, ratio  # noqa: E402
from tests.cameras import CAMERAS, SUN  # noqa: E402

SIZE = (1280, 720)
VARIANTS = {
    "fast": "fast",
    "balanced": "balanced",
    "accurate": "accurate",
    "every pixel": sa.Quality(depth="analytic"),
    "depth textures": sa.Quality(),
    "table of columns": sa.Quality(transmittance="table", depth="analytic"),
    "table4d": sa.Quality(method="table4d", depth="analytic"),
    "widths": sa.Quality(method="widths"),
}


def main(frames=9):
    ctx = sa.open_context()
    clock = Clock(ctx, SIZE)
    for title, surface in (("black ground", None), ("lit ground", sa.Surface())):
        print(f"{title:34s}" + "".join(f"{name:>18s}" for name in VARIANTS))
        for name, camera in CAMERAS.items():
            row = []
            for quality in VARIANTS.values():
                with sa.Renderer(ctx, sa.Scene(suns=SUN, surface=surface), SIZE, quality) as renderer:
                    draw = partial(renderer.render, camera)
                    clock.pairs(draw, 2)
                    row.append(ratio(clock.pairs(draw, frames)))
            print(f"{name:34s}" + "".join(f"{cost:18.1f}" for cost in row), flush=True)


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:]))
