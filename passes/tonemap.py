"""The last pass, apart from the physics: scene-linear radiance to 8-bit display values."""

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.gl.textures import Target
from shadowatmo.validation import number

MIDDLE = 0.5  # display-linear value that the reference level of an automatic exposure comes to
GLARE_PERCENTILE, REFERENCE_PERCENTILE = 99.0, 85.0
DARKEST = 1e-3  # of the glare level: what is darker than that does not count as part of the picture


class Tonemap(RenderPass):
    """Exposure, a saturating curve, the sRGB transfer function and half a step of dither."""

    name = "tonemap"
    inputs = ("color",)
    outputs = ("display",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=("rgba8",)))

    def draw(self, textures, exposure, framebuffer=None):
        (framebuffer or self.target.framebuffer).use()
        self.fullscreen("tonemap.frag", {}, {"u_exposure": exposure}, {"u_color": textures["color"]})
        textures["display"] = self.target.color[0]


def automatic_exposure(radiance) -> float:
    """Return the exposure that brings the bright part of a picture (h, w, 3) to a comfortable level.

    The level is a high percentile of the luminance of what is neither black nor glaring, so that neither space nor the
    sun's disc decides it.
    """
    luminance = np.asarray(radiance, np.float64) @ (0.2126, 0.7152, 0.0722)
    shining = luminance[luminance > 0.0]
    if shining.size == 0:
        return 1.0
    visible = shining[shining > DARKEST * np.percentile(shining, GLARE_PERCENTILE)]
    return float(-np.log1p(-MIDDLE) / np.percentile(visible, REFERENCE_PERCENTILE))


def check_exposure(exposure) -> float | None:
    """Return a valid exposure, or None for the automatic one."""
    if exposure is None:
        return None
    if isinstance(exposure, str):
        raise ParameterError("exposure", exposure, "None or a number in (0, 1e12]")
    return number("exposure", exposure, low=0.0, high=1e12, open_low=True)
