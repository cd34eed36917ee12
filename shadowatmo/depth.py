"""Depth conventions: what a depth texture holds, and the metres along a pixel's ray that it means.

The float64 twin of shaders/depth.glsl. Path length = eye-space depth x stretch, stretch = |ray| / (ray . forward).
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.validation import choice, number

CONVENTIONS = ("distance", "linear", "standard", "reversed", "logarithmic", "position")


@dataclass(frozen=True)
class DepthConvention:
    """How the values of a depth texture are to be read.

    Parameters
    ----------
    kind : str
        "distance": metres along the pixel's ray; "linear": eye-space depth along the view axis;
        "standard": z-buffer in [0, 1] with 0 at `near`; "reversed": z-buffer with 1 at `near`;
        "logarithmic": log2(1 + c z) / log2(1 + c far), 0 at the eye; "position": camera-relative xyz in the texture.
    near, far : float
        Clip planes in the texture's units; `far` may be inf for "standard" and "reversed". The far plane, like inf
        and nan in the unbounded kinds, means that nothing was drawn there.
    coefficient : float
        c of "logarithmic" [1/unit], > 0.
    meters_per_unit : float
        Size of the host's unit [m], > 0.
    """

    kind: str = "distance"
    near: float = 0.1
    far: float = math.inf
    coefficient: float = 1.0
    meters_per_unit: float = 1.0

    def __post_init__(self):
        choice("kind", self.kind, CONVENTIONS)
        object.__setattr__(self, "near", number("near", self.near, low=0, open_low=True, high=1e15))
        far = self.far if self.far == math.inf else number("far", self.far, low=self.near, open_low=True)
        if self.kind == "logarithmic" and far == math.inf:
            raise ParameterError("far", far, f"a finite number above near = {self.near:g} for logarithmic depth")
        object.__setattr__(self, "far", float(far))
        for name in ("coefficient", "meters_per_unit"):
            object.__setattr__(self, name, number(name, getattr(self, name), low=0, open_low=True, high=1e15))

    def encode(self, distance, stretch=1.0) -> np.ndarray:
        """Return the texture values of surfaces `distance` metres along their rays; inf means none.

        "position" has no single value: ParameterError.
        """
        with np.errstate(invalid="ignore"):
            d = np.asarray(distance, np.float64) / self.meters_per_unit
            z = d / stretch
            if self.kind == "distance":
                return d
            if self.kind == "linear":
                return z
            if self.kind == "logarithmic":
                coded = np.log2(1.0 + self.coefficient * z) / math.log2(1.0 + self.coefficient * self.far)
                return np.where(np.isinf(d), 1.0, coded)
            ratio = self.near / self.far
            if self.kind == "standard":
                return np.where(np.isinf(d), 1.0, (1.0 - self.near / z) / (1.0 - ratio))
            if self.kind == "reversed":
                return np.where(np.isinf(d), 0.0, (self.near / z - ratio) / (1.0 - ratio))
        raise ParameterError("kind", self.kind, "a convention with one value per pixel")

    def distance(self, values, stretch=1.0) -> np.ndarray:
        """Return metres along the rays of texture values; inf where nothing was drawn."""
        v = np.asarray(values, np.float64)
        ratio = self.near / self.far
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if self.kind == "distance":
                d = v
            elif self.kind == "linear":
                d = v * stretch
            elif self.kind == "standard":
                d = np.where(v >= 1.0, np.inf, self.near / (1.0 - v * (1.0 - ratio)) * stretch)
            elif self.kind == "reversed":
                d = np.where(v <= 0.0, np.inf, self.near / (ratio + v * (1.0 - ratio)) * stretch)
            elif self.kind == "logarithmic":
                power = np.exp2(v * math.log2(1.0 + self.coefficient * self.far))
                d = np.where(v >= 1.0, np.inf, (power - 1.0) / self.coefficient * stretch)
            else:
                d = np.linalg.norm(v, axis=-1)
        d = d * self.meters_per_unit
        return np.where(d >= 0.0, d, np.inf)
