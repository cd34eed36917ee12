"""Cost of whole frames as CPU-time ratios to a full-screen copy pass, interleaved in one run.

Usage: python bench/frame_cost.py [frames]. Meaningful where the renderer runs on the CPU (llvmpipe): process time
counts its threads, and ratios hold on a busy machine where wall time does not. The copy reads and writes one RGBA
16-bit float texel a pixel.
"""

import sys
import time
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import shadowatmo as sa  # noqa: E402
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program  # noqa: E402
from shadowatmo.passes.gl.textures import Target  # noqa: E402
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


def cpu_time(ctx, draw) -> float:
    """Return CPU seconds of one call, the driver's threads included."""
    ctx.finish()
    start = time.process_time()
    draw()
    ctx.finish()
    return time.process_time() - start


def main(frames=9):
    ctx = sa.open_context()
    source, target = (Target(ctx, SIZE, color=("rgba16f",)) for _ in range(2))
    program = build_program(ctx, "copy.frag")
    triangle = Fullscreen(ctx, program)

    def copy():
        target.framebuffer.use()
        bind_textures(program, {"u_color": source.color[0]})
        triangle.draw()

    print(f"{'ratio to the copy pass':34s}" + "".join(f"{name:>20s}" for name in VARIANTS))
    for name, camera in CAMERAS.items():
        row = []
        for quality in VARIANTS.values():
            with sa.Renderer(ctx, sa.Scene(suns=SUN), SIZE, quality) as renderer:
                for _ in range(2):
                    renderer.render(camera)
                    copy()
                draw = partial(renderer.render, camera)
                pairs = [(cpu_time(ctx, draw), cpu_time(ctx, copy)) for _ in range(frames)]
            row.append(np.median([p[0] for p in pairs]) / np.median([p[1] for p in pairs]))
        print(f"{name:34s}" + "".join(f"{ratio:20.1f}" for ratio in row), flush=True)


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:]))
