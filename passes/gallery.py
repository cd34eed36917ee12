"""Draws the demo set: one renderer for each quality that its pictures need, kept from picture to picture."""

from dataclasses import replace

import numpy as np
from PIL import Image

from shadowatmo.errors import PassError
from shadowatmo.false_color import left_half, widths_image
from shadowatmo.fisheye import face_cameras, resample
from shadowatmo.gallery import Picture
from shadowatmo.passes.develop import develop
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
    samples : int
        Rays along each side of a pixel of the pictures in color; 1 leaves steps along hard edges.
    cache, progress
        As of Renderer.
    """

    def __init__(self, ctx, size, quality="balanced", *, samples=1, cache=True, progress=None):
        self.ctx, self.size, self.quality, self.samples = ctx, size, as_quality(quality), samples
        self._tables = {"cache": cache, "progress": progress}
        self._renderers = {}

    def draw(self, picture: Picture) -> Image.Image:
        """Return a picture.

        Raises
        ------
        PassError
            If a pixel came out as NaN or infinite.
        """
        if picture.style == "fisheye":
            return self._fisheye(picture)
        if picture.style == "color":
            return self._color(picture).reduce(self.samples)
        frame = self._frame(picture, picture.quality)
        widths = (frame.read(name)[..., 0] for name in ("lit_width", "shadow_width"))
        return widths_image(*widths, left_half(frame.image(picture.exposure)) if picture.style == "split" else None)

    def _color(self, picture) -> Image.Image:
        """Return a picture before its samples are averaged: as the eye does, after the tone curve."""
        size = tuple(self.samples * n for n in self.size)
        frame = self._frame(picture, picture.quality, size)
        exposure = _exposure(picture, frame.numpy())
        image = frame.image(exposure)
        if picture.left is not None:
            other = self._frame(picture, {**picture.quality, **picture.left}, size).image(exposure)
            image.paste(left_half(other))
        return image

    def _fisheye(self, picture) -> Image.Image:
        """Return the sky above a picture's camera."""
        side = min(self.size)
        faces = [
            self._frame(replace(picture, camera=camera), picture.quality, (side, side)).numpy()
            for camera in face_cameras(picture.camera.position)
        ]
        radiance = resample(faces, self.size)
        exposure = _exposure(picture, radiance)
        renderer = self._renderer(picture, replace(self.quality, **picture.quality), self.size)
        return develop(renderer, radiance, exposure)

    def _renderer(self, picture, quality, size) -> Renderer:
        """Return the renderer of a quality and a size, with a picture's scene."""
        if (quality, size) not in self._renderers:
            self._renderers[quality, size] = Renderer(self.ctx, picture.scene, size, quality, **self._tables)
        renderer = self._renderers[quality, size]
        renderer.scene = picture.scene
        return renderer

    def _frame(self, picture, changes, size=None) -> Frame:
        """Return a picture's frame at the set's quality with some changes."""
        renderer = self._renderer(picture, replace(self.quality, **changes), size or self.size)
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


def _exposure(picture, radiance) -> float:
    """Return the exposure of a picture for its radiances (h, w, 3)."""
    return picture.exposure or picture.compensation * automatic_exposure(radiance)
