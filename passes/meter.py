"""A light meter: a linear picture made small enough to be read back between two frames."""

import numpy as np

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.gl.textures import Target

METER_SIZE = (64, 36)


class Meter(RenderPass):
    """Means of a linear color texture over a coarse grid; small bright things, the sun's disc, stay in single cells."""

    name = "meter"
    inputs = ("color",)
    outputs = ("light",)

    def __init__(self, ctx, size):
        super().__init__(ctx, tuple(min(n, limit) for n, limit in zip(size, METER_SIZE, strict=True)))
        self.cell = tuple(n / small for n, small in zip(size, self.size, strict=True))
        self.target = self.own(Target(ctx, self.size, color=("rgba32f",)))

    def draw(self, textures) -> None:
        """Measure a picture."""
        self.target.framebuffer.use()
        self.fullscreen("meter.frag", {}, {"u_cell": self.cell}, {"u_color": textures["color"]})
        textures["light"] = self.target.color[0]

    def read(self) -> np.ndarray:
        """Return radiances (h, w, 3) float32 of the picture that was measured last."""
        data = np.frombuffer(self.target.color[0].read(alignment=1), np.float32)
        return data.reshape(self.size[1], self.size[0], 4)[::-1, :, :3]
