"""What a piece of drawing costs, as a ratio to a full-screen copy that is timed beside it.

Where the renderer runs on the CPU the clock is the process's CPU time, which counts the driver's threads and holds on a
busy machine; on hardware it is a timer query.
"""

import time

import numpy as np

from shadowatmo.passes.gl.context import describe_context
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program
from shadowatmo.passes.gl.textures import Target


class Clock:
    """Times drawing beside a copy pass that reads and writes one RGBA 16-bit float texel a pixel.

    Parameters
    ----------
    ctx : moderngl.Context
    size : (int, int)
        Of the frames and of the copy [pixels].
    uses_cpu : bool, optional
        Whether CPU time is what counts; None: where the renderer is software.
    """

    def __init__(self, ctx, size, uses_cpu=None):
        self.ctx = ctx
        self._source, self._target = (Target(ctx, size, color=("rgba16f",)) for _ in range(2))
        self._program = build_program(ctx, "copy.frag")
        self._triangle = Fullscreen(ctx, self._program)
        self.uses_cpu = describe_context(ctx)["software"] if uses_cpu is None else uses_cpu
        self._query = None if self.uses_cpu else ctx.query(time=True)
        self.copies = []  # s, every copy that was timed

    @property
    def name(self) -> str:
        return "CPU time" if self.uses_cpu else "GPU timer query"

    def seconds(self, draw) -> float:
        """Return what one call costs [s]."""
        if self._query is not None:
            with self._query:
                draw()
            return self._query.elapsed * 1e-9
        self.ctx.finish()
        start = time.process_time()
        draw()
        self.ctx.finish()
        return time.process_time() - start

    def pairs(self, draw, count) -> np.ndarray:
        """Return (count, 2) seconds of a call and of one copy beside it."""
        return np.array([(self.seconds(draw), self.copy()) for _ in range(count)])

    def copy(self) -> float:
        """Return what one copy costs now [s]."""
        seconds = self.seconds(self._copy)
        self.copies.append(seconds)
        return seconds

    def _copy(self):
        self._target.framebuffer.use()
        bind_textures(self._program, {"u_color": self._source.color[0]})
        self._triangle.draw()

    def release(self) -> None:
        """Release the textures of the copy."""
        for resource in (self._source, self._target, self._triangle):
            resource.release()


def ratio(pairs) -> float:
    """Return the cost in copies of pairs (N, 2): the median of both, so that one disturbed frame does not count."""
    drawn, copied = np.median(pairs, axis=0)
    return float(drawn / max(copied, 1e-12))


def ratio_noise(pairs) -> float:
    """Return the standard error of `ratio` [copies], as far as the spread of the pairs tells it."""
    drawn, copied = np.asarray(pairs).T
    ratios = drawn / np.maximum(copied, 1e-12)
    low, high = np.percentile(ratios, [25.0, 75.0])
    return float(1.25 * 0.74 * (high - low) / np.sqrt(len(ratios)))  # of a median; quartiles as in a normal law
