"""An eclipse as a row of frames: when they are taken, and whether each step between two is one that the sun explains.

How bright a frame is depends on the sun's height too, which changes over hours. So a frame is measured by its share:
its mean radiance over that of the same frame without the moon. What the moon should leave is known without any
picture: the same share of the light scattered once, for a few rays of the frame, by the float64 twin. All orders
follow it closely while the sun is a crescent. Deep in the shadow, where some thousandths are left of both, light
scattered more often has come from farther away, and its share falls and rises at other moments: a part of each step
is granted for that.
"""

import math
from dataclasses import dataclass
from datetime import timedelta

import numpy as np
from PIL import Image

from shadowatmo import reference
from shadowatmo.camera import Camera
from shadowatmo.ephemeris import Contacts, sun_center
from shadowatmo.scene import Scene
from shadowatmo.validation import integer

GATHERED = 5.0  # how much denser the frames are about the greatest eclipse: exp(5)/10 times than at the contacts
BEFORE = 0.04  # of the time from first contact to the greatest eclipse that the row begins earlier, and ends later
GRANTED = 0.25  # of a step that is explained: how far the measured one may be from it
SLACK = 0.05  # beside that, in logarithms of the share: at its minimum in totality single scattering does not change
GRID = (6, 4)  # rays of the twin across and down a frame
AUREOLE = math.radians(2.0)  # about the sun, that counts neither in frames nor in rays
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
ADAPTATION = 0.75  # of the fall of light, in stops, that the strip's exposure follows, as an eye does


def frame_times(contacts: Contacts, count) -> list:
    """Return the times of `count` frames from before first to after last contact, dense about the greatest eclipse."""
    integer("frames", count, low=2, high=10000)
    times = []
    for u in np.linspace(-1.0, 1.0, count):
        reach = contacts.greatest - contacts.first if u < 0.0 else contacts.last - contacts.greatest
        share = math.sinh(GATHERED * u) / math.sinh(GATHERED)
        times.append(contacts.greatest + timedelta(seconds=(1.0 + BEFORE) * share * reach.total_seconds()))
    return times


def without_moons(scene) -> Scene:
    """Return a scene without its occluders."""
    return Scene(scene.atmosphere, scene.suns, (), scene.surface, scene.sun_disc)


def counted(directions, sun, position) -> np.ndarray:
    """Return which unit directions (..., 3), seen from a point (3,) [m], are not in the sun's aureole."""
    toward = sun_center(sun) - np.asarray(position)
    return directions @ (toward / np.linalg.norm(toward)) < math.cos(AUREOLE)


def mean_radiance(radiance, is_sky) -> float:
    """Return the mean luminance of the pixels (h, w, 3) of a frame that a mask (h, w) selects."""
    return float(np.mean(np.asarray(radiance, np.float64)[is_sky] @ LUMINANCE))


def explained_share(scene: Scene, camera: Camera, size) -> float:
    """Return what the moons leave of the light that the sky of a frame scatters once, by the float64 twin."""
    rays = camera.pixel_rays((GRID[0], max(round(GRID[0] * size[1] / size[0]), 1))).reshape(-1, 3)
    rays = rays[counted(rays, scene.suns[0], camera.position)]
    origins = np.tile(np.array(camera.position), (len(rays), 1))
    open_sky = without_moons(scene)
    found = reference.probe(open_sky, origins, rays)
    sky = found.end == "top"
    eclipsed = reference.probe(scene, origins[sky], rays[sky])
    return float(eclipsed.single.sum(axis=0) @ LUMINANCE / (found.single[sky].sum(axis=0) @ LUMINANCE))


@dataclass(frozen=True)
class Steps:
    """How a row of frames changes, from each of `count` frames to the next.

    Attributes
    ----------
    measured, explained : (count - 1,) ndarray
        Changes of the logarithms of the measured share and of the explained one.
    """

    measured: np.ndarray
    explained: np.ndarray

    @property
    def excess(self) -> np.ndarray:
        """How far each measured step is from the explained one, over what is granted; at most 1 without jumps."""
        return np.abs(self.measured - self.explained) / (GRANTED * np.abs(self.explained) + SLACK)


def compare_steps(shares, explained) -> Steps:
    """Return the steps of measured shares (count,) beside those of explained ones (count,)."""
    return Steps(np.diff(np.log(shares)), np.diff(np.log(explained)))


def strip_exposures(automatic) -> np.ndarray:
    """Return exposures (count,) that follow the automatic ones (count,) as far as an eye does."""
    automatic = np.asarray(automatic, np.float64)
    return automatic[0] * (automatic / automatic[0]) ** ADAPTATION


def strip(images, columns=10, gap=2) -> Image.Image:
    """Return pictures of one size in rows of at most `columns`, on black, in the order of reading."""
    width, height = images[0].size
    rows = -(-len(images) // columns)
    columns = min(columns, len(images))
    sheet = Image.new("RGB", (columns * (width + gap) - gap, rows * (height + gap) - gap))
    for number, image in enumerate(images):
        row, column = divmod(number, columns)
        sheet.paste(image, (column * (width + gap), row * (height + gap)))
    return sheet
