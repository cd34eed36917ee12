"""Draws an eclipse as a row of frames, and measures each against the same frame without the moon."""

from dataclasses import dataclass

import numpy as np
from PIL import Image

from shadowatmo.observing import observed, observed_scene
from shadowatmo.passes.develop import develop
from shadowatmo.passes.pipeline import Renderer
from shadowatmo.passes.tonemap import automatic_exposure
from shadowatmo.sequence import counted, mean_radiance, strip_exposures, without_moons


@dataclass(frozen=True)
class Sequence:
    """The frames of an eclipse.

    Attributes
    ----------
    scenes : list of Scene
        What each shows.
    radiance, share : (count,) ndarray
        Mean luminance of a frame's sky, and its ratio to that without the moon.
    exposures : (count,) ndarray
        Of the pictures.
    images : list of Image
        The pictures, exposed as an eye adapts.
    """

    scenes: list
    radiance: np.ndarray
    share: np.ndarray
    exposures: np.ndarray
    images: list[Image.Image]


def draw_sequence(ctx, planet, times, observer, camera, size, quality="balanced", **options) -> Sequence:
    """Draw the sky over an observer at some times.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.
    planet : World
        One as large as the Earth.
    times : sequence of datetime
        One for each frame.
    observer : (float, float, float)
        As of `observed`.
    camera : Camera
        The same for all frames.
    size : (int, int)
        Of a frame [pixels].
    quality, options
        As of Renderer.
    """
    scenes = [observed_scene(planet, observed(planet, time, observer)) for time in times]
    rays = camera.pixel_rays(size)
    radiance, share, frames = [], [], []
    with Renderer(ctx, scenes[0], size, quality, **options) as renderer:
        for scene in scenes:
            means = []
            for shown in (without_moons(scene), scene):
                renderer.scene = shown
                frame = renderer.render(camera)
                is_sky = np.isinf(frame.read("depth")[..., 0]) & counted(rays, scene.suns[0], camera.position)
                means.append(mean_radiance(frame.numpy(), is_sky))
            frames.append(frame.numpy())
            radiance.append(means[1])
            share.append(means[1] / means[0])
        exposures = strip_exposures([automatic_exposure(frame) for frame in frames])
        images = [develop(renderer, frame, exposure) for frame, exposure in zip(frames, exposures, strict=True)]
    return Sequence(scenes, np.array(radiance), np.array(share), exposures, images)
