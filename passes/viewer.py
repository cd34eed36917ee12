"""The viewer apart from its window: draws what the controls say into any framebuffer, and meters the light."""

from pathlib import Path

from PIL import Image

from shadowatmo.controls import HELP, Controls
from shadowatmo.passes.overlay import Overlay
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.tonemap import Tonemap, automatic_exposure

METER_SIZE = (64, 36)
METER_INTERVAL = 0.1  # s between two looks of the meter


class Viewer:
    """Draws frame after frame of a moving view.

    Parameters
    ----------
    ctx : moderngl.Context
        The window's context.
    controls : Controls
        What hands move; read at each frame.
    """

    def __init__(self, ctx, controls: Controls):
        self.ctx, self.controls = ctx, controls
        self.size = None
        self._renderer = self._meter = self._tonemap = self._overlay = None
        self._since_metering = METER_INTERVAL

    def draw(self, framebuffer, size, seconds) -> None:
        """Draw the next frame.

        Parameters
        ----------
        framebuffer : moderngl.Framebuffer
            Where to; 8-bit color.
        size : (int, int)
            Its size [pixels]; may change from frame to frame.
        seconds : float
            Time since the frame before.
        """
        self.controls.advance(seconds)
        self._prepare(tuple(size))
        scene, camera = self.controls.scene(), self.controls.camera()
        self._expose(scene, camera, seconds)
        self._renderer.scene = scene
        frame = self._renderer.render(camera)
        framebuffer.viewport = (0, 0, *self.size)
        self._tonemap.draw({"color": frame.color}, self.controls.exposure, framebuffer)
        if self.controls.wants_help:
            self._overlay.draw(HELP, framebuffer)

    def _prepare(self, size):
        """Make what draws anew when the size or the quality has changed."""
        if self._renderer is not None and (self.size, self._renderer.quality) == (size, self.controls.quality):
            return
        self.close()
        self.size = size
        scene, quality = self.controls.scene(), self.controls.quality
        self._renderer = Renderer(self.ctx, scene, size, quality)
        self._meter = Renderer(self.ctx, scene, METER_SIZE, quality)
        self._tonemap, self._overlay = Tonemap(self.ctx, size), Overlay(self.ctx, size)

    def _expose(self, scene, camera, seconds):
        """Look at a tiny copy of the frame now and then, and let the exposure follow it."""
        self._since_metering += seconds
        if not self.controls.automatic or self._since_metering < METER_INTERVAL:
            return
        self._meter.scene = scene
        target = automatic_exposure(self._meter.render(camera).numpy())
        self.controls.adapt(target, self._since_metering)
        self._since_metering = 0.0

    def picture(self) -> Image.Image:
        """Return the last frame without words."""
        return self._renderer.render(self.controls.camera()).image(self.controls.exposure)

    def save_picture(self, folder) -> Path:
        """Write the last frame into a folder, which is made where it is missing; return the path."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        number = 1
        while (path := folder / f"view_{number:03d}.png").exists():
            number += 1
        self.picture().save(path)
        return path

    def close(self) -> None:
        """Release everything that draws; the next frame makes it anew."""
        self.size = None
        for name in ("_renderer", "_meter"):
            if getattr(self, name) is not None:
                getattr(self, name).close()
                setattr(self, name, None)
        for name in ("_tonemap", "_overlay"):
            if getattr(self, name) is not None:
                getattr(self, name).release()
                setattr(self, name, None)
