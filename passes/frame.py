"""A rendered frame: textures of the renderer that made it, and their contents as arrays and pictures."""

import numpy as np
from PIL import Image

from shadowatmo.errors import PassError
from shadowatmo.passes.tonemap import automatic_exposure, check_exposure


class Frame:
    """One frame. Its textures belong to the renderer and hold this frame until the renderer draws the next one.

    Attributes
    ----------
    color : moderngl.Texture
        Linear HDR, RGBA 32-bit float: radiance, and in alpha how much of the background the air hides. Composed in
        place it is a copy of the host's texture, whose alpha stays the host's.
    depth : moderngl.Texture
        Distance [m] along the pixel's ray to whatever solid is there, inf for none; R 32-bit float.
    lit_width, shadow_width : moderngl.Texture
        Path [m] inside the air outside and inside the planet's shadow of sun 0, R 32-bit float. Of a sun with
        `disc_at_terminator` the shadow is where the limb hides its whole disc.

    Notes
    -----
    Fields other than the color are worked out when they are first asked for. With a tolerance above 0, or where a part
    of the frame shows no air, that means from the depth that `compose` was given, which must still be what it was. So
    must be a color that was composed in place.
    """

    def __init__(self, renderer, number, textures):
        self._renderer, self._number = renderer, number
        self._textures = textures

    def _field(self, name):
        self._check_current()
        if name not in self._textures:
            self._textures[name] = self._renderer.field(name, self._textures)
        return self._textures[name]

    def _check_current(self):
        if self._renderer.frame_number != self._number:
            raise PassError(f"frame {self._number} is gone: its renderer was closed or drew another; read it before")

    @property
    def color(self):
        return self._field("color")

    @property
    def depth(self):
        return self._field("depth")

    @property
    def lit_width(self):
        return self._field("lit_width")

    @property
    def shadow_width(self):
        return self._field("shadow_width")

    def read(self, name) -> np.ndarray:
        """Return one of "color", "depth", "lit_width", "shadow_width" as float32 (h, w, channels), row 0 at the top."""
        return self._renderer.read_texture(getattr(self, name))

    def numpy(self) -> np.ndarray:
        """Return scene-linear radiance, float32 (h, w, 3), row 0 at the top."""
        return np.ascontiguousarray(self.read("color")[..., :3])

    def image(self, exposure=None) -> Image.Image:
        """Return the frame as a person should see it, an 8-bit sRGB picture.

        Parameters
        ----------
        exposure : float, optional
            Factor on radiance before the tone curve, > 0. None: chosen from the frame's bright part.
        """
        exposure = check_exposure(exposure)
        if exposure is None:
            exposure = automatic_exposure(self.numpy())
        return Image.fromarray(self._renderer.tonemapped(self.color, exposure))

    def _repr_png_(self) -> bytes:
        return self.image()._repr_png_()
