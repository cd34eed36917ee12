"""The viewer apart from its window: draws what the controls say into any framebuffer, and meters the light."""

from pathlib import Path

from PIL import Image

from shadowatmo.controls import HELP, Controls
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.meter import Meter
from shadowatmo.passes.overlay import Overlay
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.tonemap import Tonemap, automatic_exposure

METER_INTERVAL = 0.1  # s between two looks of the meter
TABLE_BUDGET = 0.03  # s of a frame for tables: it goes without one, or with the last, rather than wait


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
        self._renderer, self._after = None, {}
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
        self._renderer.scene = self.controls.scene()
        color = self._renderer.render(self.controls.camera()).color
        framebuffer.viewport = (0, 0, *self.size)
        with preserve_state(self.ctx):  # or our textures stay bound after they are released
            self._expose(color, seconds)
            self._after["tonemap"].draw({"color": color}, self.controls.exposure, framebuffer)
            if self.controls.wants_help:
                self._after["overlay"].draw(HELP, framebuffer)

    def _prepare(self, size):
        """Make what draws anew when the size or the quality has changed."""
        if self._renderer is not None and (self.size, self._renderer.quality) == (size, self.controls.quality):
            return
        self.close()
        self.size = size
        controls = self.controls
        tables = {"cache": controls.cache, "table_budget": TABLE_BUDGET}
        self._renderer = Renderer(self.ctx, controls.scene(), size, controls.quality, **tables)
        with preserve_state(self.ctx):
            for kind in (Meter, Tonemap, Overlay):
                self._after[kind.name] = kind(self.ctx, size)

    def _expose(self, color, seconds):
        """Measure the frame now and then, and let the exposure follow it."""
        self._since_metering += seconds
        if not self.controls.automatic or self._since_metering < METER_INTERVAL:
            return
        self._after["meter"].draw({"color": color})
        self.controls.adapt(automatic_exposure(self._after["meter"].read()), self._since_metering)
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
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        while self._after:
            self._after.popitem()[1].release()
