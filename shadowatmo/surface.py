"""Color and relief of the ground, as equirectangular maps (left edge 180 W, top edge 90 N, north pole on +z)."""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from PIL import Image

from shadowatmo.errors import ParameterError
from shadowatmo.validation import instance, number

EARTH_METERS_AT_WHITE = 6400.0  # altitude of the brightest level of the vendored height map


@dataclass(frozen=True)
class Surface:
    """The ground's look. Longitude 0 lies on +x, longitude 90 E on +y, the north pole on +z.

    Parameters
    ----------
    color : path, optional
        sRGB image, equirectangular; taken as albedo. None: the atmosphere's `ground_albedo` everywhere.
    height : path, optional
        Gray image, equirectangular, linear from altitude 0 at black. None: a smooth sphere.
    meters_at_white : float
        Altitude that the height map's white stands for [m], >= 0.
    relief_scale : float
        Exaggeration of the relief, >= 0; 1 is true to scale.
    sea : bool
        Whether altitude 0 of the height map is water, which mirrors sun and sky.

    Raises
    ------
    ParameterError
        If a file is missing or a number is out of range.
    """

    color: Path | None = None
    height: Path | None = None
    meters_at_white: float = EARTH_METERS_AT_WHITE
    relief_scale: float = 1.0
    sea: bool = False

    def __post_init__(self):
        for name in ("color", "height"):
            path = getattr(self, name)
            if path is not None and not Path(path).is_file():
                raise ParameterError(name, str(path), "None or the path of an existing image file")
        instance("sea", self.sea, bool, "True or False")
        for name in ("meters_at_white", "relief_scale"):
            object.__setattr__(self, name, number(name, getattr(self, name), low=0, high=1e6))

    @classmethod
    def earth(cls) -> "Surface":
        """The Earth: Blue Marble color and GEBCO heights that come with the package (see CREDITS.md)."""
        data = files("shadowatmo.data")
        return cls(color=Path(str(data / "earth_color.jpg")), height=Path(str(data / "earth_height.png")), sea=True)

    def load_color(self) -> np.ndarray | None:
        """Return the color map, (rows, columns, 3) uint8 sRGB, north at the top; None without one."""
        if self.color is None:
            return None
        with Image.open(self.color) as image:
            return np.asarray(image.convert("RGB"))

    def load_height(self) -> np.ndarray | None:
        """Return altitudes [m], (rows, columns) float32, north at the top; None without a height map."""
        if self.height is None:
            return None
        with Image.open(self.height) as image:
            levels = np.asarray(image, dtype=np.float32)
        if levels.ndim != 2:
            raise ParameterError("height", str(self.height), "a gray image with one channel")
        return levels * np.float32(self.meters_at_white * self.relief_scale / 255.0)
