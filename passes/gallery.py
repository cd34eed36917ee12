"""Draws the demo set: one renderer for each quality that its pictures need, kept from picture to picture."""

from dataclasses import replace

import numpy as np
from PIL import Image

from shadowatmo.errors import PassError
from shadowatmo.false_color import widths_image
from shadowatmo.gallery import Picture
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.quality import as_quality


class Gallery:
    """Draws pictures of one size.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.
    size : (int, int)
        Width and height of the pictures [pixels].
    quality : Quality or str
        Effort; a picture may change single fields of it.
    """

    def __init__(self, ctx, size, quality="balanced"):
        self.ctx, self.size, self.quality = ctx, size, as_quality(quality)
        self._renderers = {}

    def draw(self, picture: Picture) -> Image.Image:
        """Return a picture.

        Raises
        ------
        PassError
            If a pixel came out as NaN or infinite.
        """
        frame = self._renderer(picture).render(picture.camera)
        if not np.isfinite(frame.numpy()).all():
            raise PassError(f"picture {picture.name} has pixels that are not finite; please report it")
        color = None if picture.style == "widths" else frame.image(picture.exposure)
        if picture.style == "color":
            return color
        return widths_image(frame.read("lit_width")[..., 0], frame.read("shadow_width")[..., 0], color)

    def _renderer(self, picture) -> Renderer:
        """Return the renderer of a picture's quality, set to its scene."""
        quality = replace(self.quality, **picture.quality)
        if quality not in self._renderers:
            self._renderers[quality] = Renderer(self.ctx, picture.scene, self.size, quality)
        renderer = self._renderers[quality]
        renderer.scene = picture.scene
        return renderer

    def close(self) -> None:
        """Release the renderers."""
        while self._renderers:
            self._renderers.popitem()[1].close()

    def __enter__(self) -> "Gallery":
        return self

    def __exit__(self, *exception) -> None:
        self.close()
