"""Words over a finished picture: lines of text drawn by Pillow, blended over a framebuffer."""

import moderngl
import numpy as np
from PIL import Image, ImageDraw

from shadowatmo.false_color import font
from shadowatmo.passes.base import RenderPass

MARGIN, GAP = 16, 22  # pixels: from the corner, and between the columns
PLATE = (8, 10, 14, 170)  # color behind the words
KEYS_INK, INK = (255, 206, 120, 255), (232, 232, 228, 255)


class Overlay(RenderPass):
    """A table of keys and meanings in the upper left corner."""

    name = "overlay"
    inputs = ("display",)
    outputs = ("display",)

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self._rows, self._words = None, None

    def draw(self, rows, framebuffer) -> None:
        """Draw rows of (keys, meaning) over a framebuffer of this pass's size."""
        if rows != self._rows:
            image = words(rows, max(self.size[1] // 44, 11))
            if self._words is not None:
                self._words.release()
            self._words = self.ctx.texture(image.size, 4, np.asarray(image).tobytes(), alignment=1)
            self._rows = rows
        framebuffer.use()
        self.ctx.enable(moderngl.BLEND)
        self.ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        corner = (float(MARGIN), float(self.size[1] - MARGIN))
        self.fullscreen("overlay.frag", {}, {"u_corner": corner}, {"u_words": self._words})
        self.ctx.disable(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ZERO

    def release(self) -> None:
        """Release everything that the pass made."""
        if self._words is not None:
            self._words.release()
            self._words = self._rows = None
        super().release()


def words(rows, height) -> Image.Image:
    """Return rows of (keys, meaning) as a picture with an alpha channel, letters `height` pixels high."""
    letters, line = font(height), round(1.5 * height)
    first = max(letters.getlength(keys) for keys, _ in rows)
    second = max(letters.getlength(meaning) for _, meaning in rows)
    image = Image.new("RGBA", (int(first + second) + 3 * GAP, line * len(rows) + GAP), PLATE)
    draw = ImageDraw.Draw(image)
    for number, (keys, meaning) in enumerate(rows):
        y = GAP // 2 + number * line
        draw.text((GAP, y), keys, KEYS_INK, letters)
        draw.text((2 * GAP + first, y), meaning, INK, letters)
    return image
