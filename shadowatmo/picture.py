"""One picture of a demo set, as data."""

from dataclasses import dataclass, field

from shadowatmo.camera import Camera
from shadowatmo.scene import Scene


@dataclass(frozen=True)
class Picture:
    """One picture of the set.

    Parameters
    ----------
    name : str
        Also the name of the file.
    caption : str
        What it shows.
    scene, camera : Scene, Camera
        What is drawn and from where.
    quality : dict
        What this picture needs changed in the quality that the whole set is drawn with.
    left : dict, optional
        What the left half has changed further in its quality, for comparison.
    style : str
        "color": the tonemapped frame; "fisheye": the whole sky above the camera; "widths": lit and shadowed widths in
        false color; "split": the frame on the left and its widths on the right.
    exposure : float, optional
        Factor on radiance; None: automatic.
    compensation : float
        Factor on the automatic exposure.
    """

    name: str
    caption: str
    scene: Scene
    camera: Camera
    quality: dict = field(default_factory=dict)
    left: dict | None = None
    style: str = "color"
    exposure: float | None = None
    compensation: float = 1.0
