"""One camera over one scene: everything that the CPU works out in float64 before a pass draws."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shadowatmo.camera import Camera
from shadowatmo.parameters import Sun
from shadowatmo.passes.constants import air_uniforms, cone_uniforms, shadow_cone
from shadowatmo.quality import Quality
from shadowatmo.scene import Scene
from shadowatmo.screen import around, in_steps, meet, sphere_window
from shadowatmo.shadow import Cone
from shadowatmo.terminator import night_cone

REVERSED_NEAR = 1e-3  # m, where our reversed depth reaches 1; with a float's range it costs no precision to be so small
COARSEST, REMOTE_STEP = 2.0**-24, 5e-4  # a float's step; the step, as a share of the air's depth, that is too coarse
AIR_MARGIN = 1e-5  # of the top's radius, by which float32 may see air beside it
FAR_RADII = 2.0  # distance from the center, in ground radii, beyond which the tangent point comes from the moment


@dataclass(frozen=True)
class View:
    """A camera, a frame size and a scene, as uniforms.

    Parameters
    ----------
    scene, quality, camera : Scene, Quality, Camera
        What is drawn, how, and from where.
    size : (int, int)
        Width and height of the frame [pixels].
    """

    scene: Scene
    quality: Quality
    camera: Camera
    size: tuple[int, int]

    @cached_property
    def position(self) -> np.ndarray:
        """Camera position (3,) [m]."""
        return np.array(self.camera.position)

    @cached_property
    def radius(self) -> float:
        """Distance of the camera from the planet's center [m]."""
        return float(np.linalg.norm(self.position))

    @cached_property
    def altitude(self) -> float:
        """Altitude of the camera [m]."""
        return self.radius - self.scene.atmosphere.bottom_radius

    @cached_property
    def up(self) -> np.ndarray:
        """Unit vector (3,) from the planet's center to the camera; the north pole's at the center itself."""
        return self.position / self.radius if self.radius > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def is_far(self) -> bool:
        """Whether the tangent point of a ray is better taken from the moment than from the altitude."""
        return self.radius > FAR_RADII * self.scene.atmosphere.bottom_radius

    @cached_property
    def is_remote(self) -> bool:
        """Whether a distance from the camera in float32 loses what counts: none then comes from a texture."""
        published = self.quality.depth_bits == 24
        return not published and self.radius * COARSEST > REMOTE_STEP * self.scene.atmosphere.thickness

    @cached_property
    def is_inside(self) -> bool:
        """Whether the camera is inside the air, beyond the doubt of float32."""
        return self.altitude < (1.0 - 1e-5) * self.scene.atmosphere.thickness

    @cached_property
    def air_window(self) -> tuple[int, int, int, int] | None:
        """Window (left, bottom, right, top) of the pixels that may look through air, see screen.py; None: none do."""
        top = (1.0 + AIR_MARGIN) * self.scene.atmosphere.top_radius
        return sphere_window(self.camera, self.size, -self.position, top)

    def sun_seen(self, sun: Sun) -> tuple[np.ndarray, float]:
        """Return the unit vector (3,) from the camera to a sun's center and the sine of its disc's angular radius.

        The disc stands where the camera sees it, as the moons before it do, which is not quite where all light comes
        from.
        """
        toward = sun.distance * np.array(sun.direction) - self.position
        distance = max(float(np.linalg.norm(toward)), 1e-30)
        return toward / distance, min(sun.radius / distance, 1.0)

    def disc_reach(self, sun: Sun) -> tuple[float, float, float, float]:
        """Return the unit vector to a sun's disc and the sine of the angle that it takes, its soft edge included."""
        toward, sine = self.sun_seen(sun)
        return *toward, min(sine + self.pixel_angle, 1.0)

    def windows(self, sun: Sun, step=1) -> tuple[tuple | None, tuple | None]:
        """Return the window that may show air, in steps of pixels, and that of the sun's disc beside it; None: nothing.

        A disc that touches the first window makes that one larger.
        """
        air, disc = self.air_window, None
        if air is not None:
            air = in_steps(air, step, self.size)
        if self.scene.sun_disc:
            *toward, sine = self.disc_reach(sun)
            disc = sphere_window(self.camera, self.size, toward, sine)
        if air is not None and disc is not None and meet(air, disc):
            return in_steps(around(air, disc), step, self.size), None
        return air, disc

    @cached_property
    def axes(self) -> np.ndarray:
        """Right, up and forward as the columns of (3, 3); the first two carry the tangents of the half angles."""
        tan_x, tan_y = self.camera.tangents(self.size)
        return self.camera.basis().T * (tan_x, tan_y, 1.0)

    @cached_property
    def to_clip(self) -> np.ndarray:
        """Matrix (4, 4) from planet-centered metres to clip x, y and eye depth (as w)."""
        matrix = np.zeros((4, 4))
        right, up, forward = self.camera.basis()
        tan_x, tan_y = self.camera.tangents(self.size)
        for row, axis in ((0, right / tan_x), (1, up / tan_y), (3, forward)):
            matrix[row, :3] = axis
            matrix[row, 3] = -axis @ self.position
        return matrix

    @cached_property
    def clip_planes(self) -> tuple[float, float]:
        """Near and far [m] of our own depth; the far plane of the reversed one is infinite.

        The published one must have its near plane before whatever comes first: the air, or inside it the ground.
        """
        if self.quality.depth_bits == 32:
            return REVERSED_NEAR, float("inf")
        nearest, farthest = self.air_range
        return max(0.1 * (nearest or self.altitude), 0.1), 1.01 * farthest

    @cached_property
    def air_range(self) -> tuple[float, float]:
        """Distances [m] to the nearest and the farthest point of the air."""
        top = self.scene.atmosphere.top_radius
        return max(self.radius - top, 0.0), self.radius + top

    @cached_property
    def pixel_angle(self) -> float:
        """Angle [rad] of a pixel in the middle of the frame."""
        return 2.0 * self.camera.tangents(self.size)[1] / self.size[1]

    def defines(self) -> dict:
        """Return the features of camera.glsl and depth.glsl."""
        features = {"HAS_FAR_CAMERA": self.is_far, "HAS_PUBLISHED_DEPTH": self.quality.depth_bits == 24}
        return {name: True for name, wanted in features.items() if wanted}

    def camera_uniforms(self) -> dict:
        """Return the uniforms of camera.glsl and ray.glsl."""
        altitude, atmosphere = self.altitude, self.scene.atmosphere
        uniforms = {
            **air_uniforms(atmosphere),
            "u_pixel_to_screen": (2.0 / self.size[0], 2.0 / self.size[1]),
            "u_axes": self.axes,
            "u_position_dots": self.position @ self.axes,
            "u_camera_k": altitude * (2.0 * atmosphere.bottom_radius + altitude),
        }
        if self.is_far:
            uniforms["u_moments"] = np.cross(self.position, self.axes.T).T
        return uniforms

    def depth_uniforms(self) -> dict:
        """Return the uniforms of depth.glsl for our own textures, those of camera.glsl included."""
        near, far = self.clip_planes
        return {**self.camera_uniforms(), "u_clip_planes": (near, min(far, 3e38))}

    def axis_uniforms(self, sun: Sun) -> dict:
        """Return the planet's shadow axis and cone for one sun, as seen from the camera."""
        direction = -np.array(sun.direction)
        return {
            "u_shadow_axis.direction": direction,
            "u_shadow_axis.off": np.cross(self.position, direction),
            "u_shadow_axis.z": self.position @ direction,
        }

    def has_terminator(self, sun: Sun) -> bool:
        """Return whether the planet's limb hides a finite disc of one sun; the method "segments" alone can do that."""
        return sun.disc_at_terminator and self.quality.method == "segments"

    def shadow_cone(self, sun: Sun) -> Cone:
        """Return the planet's shadow of one sun in the shape that the quality asks for.

        Where the limb hides a finite disc, it is where the whole disc is hidden, and the light fades before it.
        """
        if self.has_terminator(sun):
            return night_cone(self.scene.atmosphere.bottom_radius, sun)
        return shadow_cone(self.scene.atmosphere, sun, self.quality.shadow)

    def shadow_uniforms(self, sun: Sun) -> dict:
        """Return axis and cone of the planet's shadow."""
        return {**self.axis_uniforms(sun), **cone_uniforms("u_shadow", self.shadow_cone(sun))}
