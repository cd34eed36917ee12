"""Where the picture is taken from, and the rays of its pixels."""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.depth import DepthConvention
from shadowatmo.errors import ParameterError
from shadowatmo.validation import choice, instance, number, unit_vector, vector

PARALLEL = 1e-6  # sine of the angle below which `up` no longer says where the top of the picture is


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera.

    The pixel in column i (from the left) and row j (from the top) of a w x h frame looks along
    forward + (2(i+.5)/w - 1) (w/h) tan(fov/2) right + (1 - 2(j+.5)/h) tan(fov/2) up, with right = forward x up.

    Parameters
    ----------
    position : (3,) float
        Planet-centered [m].
    target : (3,) float, optional
        Point in the middle of the picture [m]. Give either `target` or `forward`.
    forward : (3,) float, optional
        Direction of the view axis; normalized here.
    up : (3,) float
        Points to the top of the picture; made perpendicular to `forward`. Where it is parallel to `forward` the
        coordinate axis that is the most perpendicular takes its place.
    vertical_fov : float
        Full angle of the picture's height [rad], in (0, pi).
    depth : DepthConvention
        How a depth texture handed to `Renderer.compose` is to be read.

    Raises
    ------
    ParameterError
        If a value is not finite or out of range, or if `target` and `forward` are both given or both missing.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float] | None = None
    forward: tuple[float, float, float] | None = None
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    vertical_fov: float = math.pi / 3
    depth: DepthConvention = DepthConvention()

    def __post_init__(self):
        position = vector("position", self.position, low=-1e15, high=1e15)
        if (self.target is None) == (self.forward is None):
            raise ParameterError("target", self.target, "exactly one of target and forward to be given")
        if self.target is not None:
            target = vector("target", self.target, low=-1e15, high=1e15)
            if target == position:
                raise ParameterError("target", self.target, f"a point other than position = {position}")
            axis = np.subtract(target, position)
        else:
            target, axis = None, self.forward
        fov = number("vertical_fov", self.vertical_fov, low=0, high=math.pi, open_low=True, open_high=True)
        instance("depth", self.depth, DepthConvention, "a DepthConvention")
        values = {
            "position": position,
            "target": target,
            "forward": unit_vector("forward", axis),
            "up": vector("up", self.up, nonzero=True),
            "vertical_fov": fov,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_view(
        cls, view, vertical_fov, *, layout, planet_center=(0.0, 0.0, 0.0), meters_per_unit=1.0, depth=None
    ) -> "Camera":
        """Make the camera of a host's view matrix.

        Parameters
        ----------
        view : (4, 4) float
            From the host's world to eye space, where the eye looks along -z and y is up.
        vertical_fov : float
            Full angle of the picture's height [rad].
        layout : str
            "row-vector": translation in the last row, as pyrr has it; "column-vector": in the last column, as NumPy
            shows a PyGLM matrix. An array alone cannot tell.
        planet_center : (3,) float
            The planet's center in the host's world [units].
        meters_per_unit : float
            Size of the host's unit [m].
        depth : DepthConvention, optional
            The host's depth; in metres per unit of its own.

        Raises
        ------
        ParameterError
            If the matrix is not a rotation and a translation, or another value is out of range.
        """
        choice("layout", layout, ("row-vector", "column-vector"))
        allowed = "a finite (4, 4) matrix of a rotation and a translation"
        try:
            matrix = np.array(view, np.float64)
        except (TypeError, ValueError):
            raise ParameterError("view", view, allowed) from None
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            raise ParameterError("view", view, allowed)
        matrix = matrix.T if layout == "row-vector" else matrix
        rotation = matrix[:3, :3]
        # float32 matrices are orthogonal to a few 1e-7 only
        if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4) or not np.allclose(matrix[3], (0, 0, 0, 1)):
            raise ParameterError("view", view, f"{allowed}; is layout={layout!r} right?")
        unit = number("meters_per_unit", meters_per_unit, low=0, open_low=True, high=1e15)
        eye = -rotation.T @ matrix[:3, 3] - np.array(vector("planet_center", planet_center))
        return cls(
            position=tuple(eye * unit),
            forward=tuple(-rotation[2]),
            up=tuple(rotation[1]),
            vertical_fov=vertical_fov,
            depth=DepthConvention() if depth is None else depth,
        )

    def basis(self) -> np.ndarray:
        """Return right, up, forward as the rows of a (3, 3) float64 rotation."""
        forward = np.array(self.forward)
        up = np.array(unit_vector("up", self.up))
        right = np.cross(forward, up)
        if np.linalg.norm(right) < PARALLEL:
            right = np.cross(forward, np.eye(3)[np.argmin(np.abs(forward))])
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(right, forward), forward])

    def tangents(self, size) -> tuple[float, float]:
        """Return the tangents of the half angles (horizontal, vertical) for a frame of `size` = (width, height)."""
        vertical = math.tan(self.vertical_fov / 2)
        return vertical * size[0] / size[1], vertical

    def pixel_rays(self, size) -> np.ndarray:
        """Return unit directions (height, width, 3) float64 of all pixels of a frame, row 0 at the top."""
        width, height = size
        tan_x, tan_y = self.tangents(size)
        x = (2 * (np.arange(width) + 0.5) / width - 1) * tan_x
        y = (1 - 2 * (np.arange(height) + 0.5) / height) * tan_y
        right, up, forward = self.basis()
        rays = forward + x[None, :, None] * right + y[:, None, None] * up
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)
