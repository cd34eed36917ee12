"""Pictures of radiances that are arrays, by the same tone curve as those of frames."""

import numpy as np
from PIL import Image


def develop(renderer, radiance, exposure) -> Image.Image:
    """Return radiances (h, w, 3), row 0 at the top, of a renderer's size as a person should see them."""
    data = np.ascontiguousarray(radiance[::-1], np.float32)
    texture = renderer.ctx.texture(renderer.size, 3, data, alignment=1, dtype="f4")
    try:
        return Image.fromarray(renderer.tonemapped(texture, exposure))
    finally:
        texture.release()
