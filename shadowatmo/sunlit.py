"""Float64 twin of shaders/sunlit.glsl: what a surface sees of a sun past moons, rings and the planet itself."""

import numpy as np

from shadowatmo.eclipse import visibility
from shadowatmo.errors import ParameterError
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.rays import Rays
from shadowatmo.scene import Scene
from shadowatmo.terminator import angular_radius, elevation_sine
from shadowatmo.terminator_moons import visibility_above_limb
from shadowatmo.validation import instance, integer

STRIPS = 16  # at which a constant is interpolated: without air every strip of the disc is as bright as the next


def visible_sun(scene: Scene, points, sun: int = 0) -> np.ndarray:
    """Return the fraction of a sun's light that reaches points without air: past moons, rings and the planet.

    With `Sun(disc_at_terminator=True)` the planet's limb hides the disc bit by bit, straight over it, which holds
    within tens of the planet's radii; else its shadow is that of a sun whose light is parallel.

    Parameters
    ----------
    scene : Scene
    points : (N, 3) or (3,) float
        [m], planet-centered.
    sun : int
        Which of the scene's suns.

    Returns
    -------
    (N,) ndarray
        In [0, 1].

    Raises
    ------
    ParameterError
        If the points are not finite or not (N, 3), or there is no such sun.
    """
    instance("scene", scene, Scene, "a Scene")
    star = scene.suns[integer("sun", sun, low=0, high=len(scene.suns) - 1)]
    try:
        points = Rays.validated(points, np.ones(np.shape(points))).origins
    except ParameterError as error:
        raise ParameterError("points", error.value, error.allowed) from None
    radius, ground = np.linalg.norm(points, axis=1), scene.atmosphere.bottom_radius
    y = points @ np.array(star.direction)
    if not star.disc_at_terminator:
        across = np.linalg.norm(np.cross(points, star.direction), axis=1)
        return np.where((y < 0.0) & (across < ground), 0.0, visibility(points, star, scene))
    sine = elevation_sine(scene.atmosphere, (radius - ground) * (radius + ground), y)
    last = np.arccos(np.clip(-np.arcsin(np.clip(sine, -1.0, 1.0)) / angular_radius(star), -1.0, 1.0))
    share = (last - np.sin(last) * np.cos(last)) / np.pi
    light = np.ones((len(points), len(gauss_legendre(STRIPS)[0]), 3))
    return share * visibility_above_limb(points, star, scene, last, light)[:, 0]
