"""Draws the demo set: one renderer for each quality that its pictures need, kept from picture to picture."""

from dataclasses import replace

import numpy as np
from PIL import Image

from shadowatmo.errors import PassError
from shadowatmo.false_color import left_half, widths_image
from shadowatmo.gallery import Picture
from shadowatmo.passes.frame import Frame
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.tonemap import automatic_exposure
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
    cache, progress
        As of Renderer.
    """

    def __init__(self, ctx, size, quality="balanced", *, cache=True, progress=None):
        self.ctx, self.size, self.quality = ctx, size, as_quality(quality)
        self._tables = {"cache": cache, "progress": progress}
        self._renderers = {}

    def draw(self, picture: Picture) -> Image.Image:
        """Return a picture.

        Raises
        ------
        PassError
            If a pixel came out as NaN or infinite.
        """
        frame = self._frame(picture, picture.quality)
        if picture.style == "color":
            exposure = picture.exposure or automatic_exposure(frame.numpy())
            image = frame.image(exposure)
            if picture.left is not None:
                other = self._frame(picture, {**picture.quality, **picture.left}).image(exposure)
                image.paste(left_half(other))
            return image
        widths = (frame.read(name)[..., 0] for name in ("lit_width", "shadow_width"))
        return widths_image(*widths, left_half(frame.image(picture.exposure)) if picture.style == "split" else None)

    def _frame(self, picture, changes) -> Frame:
        """Return a picture's frame at the set's quality with some changes."""
        quality = replace(self.quality, **changes)
        if quality not in self._renderers:
            self._renderers[quality] = Renderer(self.ctx, picture.scene, self.size, quality, **self._tables)
        renderer = self._renderers[quality]
        renderer.scene = picture.scene
        frame = renderer.render(picture.camera)
        if not np.isfinite(frame.numpy()).all():
            raise PassError(f"picture {picture.name} has pixels that are not finite; please report it")
        return frame

    def close(self) -> None:
        """Release the renderers."""
        while self._renderers:
            self._renderers.popitem()[1].close()

    def __enter__(self) -> "Gallery":
        return self

    def __exit__(self, *exception) -> None:
        self.close()
