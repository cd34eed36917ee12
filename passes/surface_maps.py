"""A surface's images as textures: color decoded from sRGB by the texture unit, relief as slopes, altitude and sea."""

import moderngl
import numpy as np

from shadowatmo.passes.gl.context import context_store

SRGB8_ALPHA8 = 0x8C43


class SurfaceMaps:
    """Textures of one Surface, with mipmaps; `relief` and `color` are None where the surface has none.

    Loading takes a third of a second, so renderers of one context share the maps of a surface: `acquire` them, and
    `release` them once for each time; the last release frees the textures.
    """

    @classmethod
    def acquire(cls, ctx, surface) -> "SurfaceMaps":
        """Return the context's maps of a surface, made at the first call."""
        store = context_store(ctx).setdefault("surface_maps", {})
        if surface not in store:
            store[surface] = cls(ctx, surface)
        store[surface].users += 1
        return store[surface]

    def __init__(self, ctx, surface):
        self.ctx, self.surface, self.users = ctx, surface, 0
        self.color, self.relief, self.highest = None, None, 0.0
        color, height = surface.load_color(), surface.load_height()
        try:
            if color is not None:
                opaque = np.dstack([color, np.full(color.shape[:2], 255, np.uint8)])
                self.color = self._texture(opaque, "f1", SRGB8_ALPHA8)
            if height is not None and (height.any() or surface.sea):
                self.highest = float(height.max())
                self.relief = self._texture(relief(height), "f4", None)
        except BaseException:
            self._free()
            raise

    def _texture(self, rows, dtype, internal_format):
        """Upload rows that begin in the north; GL wants the south first."""
        height, width, channels = rows.shape
        data = np.ascontiguousarray(rows[::-1]).tobytes()
        options = {} if internal_format is None else {"internal_format": internal_format}
        texture = self.ctx.texture((width, height), channels, data, dtype=dtype, **options)
        texture.build_mipmaps()
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        texture.repeat_x, texture.repeat_y = True, False
        return texture

    def defines(self) -> dict:
        """Return the features of surface.glsl."""
        present = {
            "HAS_COLOR_MAP": self.color is not None,
            "HAS_RELIEF": self.relief is not None,
            "HAS_WATER": self.relief is not None and self.surface.sea,
        }
        return {name: True for name, value in present.items() if value}

    def textures(self) -> dict:
        """Return the samplers of surface.glsl."""
        maps = {"u_color_map": self.color, "u_relief_map": self.relief}
        return {name: texture for name, texture in maps.items() if texture is not None}

    def release(self) -> None:
        """Give the maps back; the textures go with their last user."""
        self.users -= 1
        if self.users == 0:
            context_store(self.ctx)["surface_maps"].pop(self.surface, None)
            self._free()

    def _free(self):
        for texture in (self.color, self.relief):
            if texture is not None:
                texture.release()
        self.color = self.relief = None


def relief(height, radius=6.36e6) -> np.ndarray:
    """Return (rows, columns, 4) float32 of an altitude map [m]: slopes to the east and north, altitude [m], 1 on sea.

    Central differences on the sphere of `radius` [m]; longitudes wrap. Slopes near the poles, where columns crowd, are
    taken over at least the spacing at 85 degrees.
    """
    rows, columns = height.shape
    latitude = np.pi * (0.5 - (np.arange(rows) + 0.5) / rows)
    spacing = 2.0 * np.pi * radius / columns * np.maximum(np.cos(latitude), np.cos(np.radians(85.0)))
    east = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) / (2.0 * spacing[:, None])
    padded = np.pad(height, ((1, 1), (0, 0)), mode="edge")
    north = (padded[:-2] - padded[2:]) / (2.0 * np.pi * radius / rows)
    return np.dstack([east, north, height, height <= 0.0]).astype(np.float32)
