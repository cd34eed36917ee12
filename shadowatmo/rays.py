"""Rays in, arrays out: the validated input of a probe, and the record of what it found along each ray."""

from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError

ENDS = ("top", "ground", "t_max", "miss")


@dataclass(frozen=True, eq=False)
class Rays:
    """Half-lines x(t) = origin + t direction, 0 <= t <= t_max, planet-centered.

    Build one with :meth:`validated`, which checks and normalizes.

    Parameters
    ----------
    origins : (N, 3) float64
        Start points [m].
    directions : (N, 3) float64
        Unit vectors.
    t_max : (N,) float64
        Where the scene blocks each ray [m]; inf where nothing does.
    """

    origins: np.ndarray
    directions: np.ndarray
    t_max: np.ndarray

    def __len__(self) -> int:
        return len(self.origins)

    def __getitem__(self, index) -> "Rays":
        """Return the rays that a slice, mask or index array selects."""
        return Rays(self.origins[index], self.directions[index], self.t_max[index])

    @classmethod
    def validated(cls, origins, directions, t_max=None) -> "Rays":
        """Check the arrays, normalize the directions in float64 and return the rays.

        Parameters
        ----------
        origins : (N, 3) or (3,) float
            Start points [m], finite; a single (3,) makes one ray. N = 0 is allowed.
        directions : (N, 3) or (3,) float
            Any finite length but zero; same shape as `origins`.
        t_max : (N,) float or float, optional
            Far end of each ray [m], >= 0, inf for none. None: none.

        Raises
        ------
        ParameterError
            Naming origins, directions or t_max: not numeric, wrong shape, not finite, a zero direction,
            t_max below 0.
        """
        start = _points("origins", origins)
        toward = _points("directions", directions)
        if toward.shape != start.shape:
            raise ParameterError(
                "directions", toward.shape, f"the shape {start.shape} of origins; this is its shape"
            )
        largest = np.abs(toward).max(axis=1, keepdims=True)
        if not np.all(largest > 0):
            worst = int(np.argmin(largest))
            raise ParameterError(
                "directions", toward[worst].tolist(), f"not zero in any ray (this is ray {worst})"
            )
        toward = toward / largest  # keeps the square root away from overflow and underflow
        toward /= np.sqrt(np.einsum("ij,ij->i", toward, toward))[:, None]
        return cls(start, toward, _limits(t_max, len(start)))


@dataclass(frozen=True, eq=False)
class ProbeResult:
    """What N rays met in the air, with M occluders in the scene.

    Fields that a call did not compute are None. Lengths are 0 where a ray misses the air, and only count the
    part of the ray inside the air and before its end.

    Parameters
    ----------
    t_in, t_out, t_end : (N,) float
        Where the ray enters the air (0 if it starts inside), where its line leaves the top sphere (ground
        ignored), and where the segment ends [m from the origin]; nan on a miss.
    end : (N,) str
        What ends the segment: "top", "ground", "t_max", or "miss".
    transmittance : (N, 3) float
        exp(-optical depth) of the segment; 1 on a miss.
    single, multiple : (N, 3) float
        Light scattered into the ray once / more than once, radiance per unit solar irradiance [1/sr] where
        the sun's irradiance is 1; 0 on a miss.
    ground_direct, ground_multiple : (N, 3) float
        Sunlight / skylight that the ground at the end of the ray reflects, view transmittance included
        [1/sr]; 0 unless `end` is "ground".
    lit, shadow : (N,) float
        Length outside / inside the planet's parallel-sun shadow of sun 0 [m].
    planet_umbra, planet_penumbra : (N,) float
        Length inside the planet's umbra cone / inside its outer cone but not in the umbra, sun 0 [m].
    umbra, antumbra, penumbra : (N, M) float
        Length inside each occluder's umbra, antumbra, and inside its outer cone but in neither, sun 0 [m].
    """

    t_in: np.ndarray
    t_out: np.ndarray
    t_end: np.ndarray
    end: np.ndarray
    transmittance: np.ndarray | None
    single: np.ndarray | None
    multiple: np.ndarray | None
    ground_direct: np.ndarray | None
    ground_multiple: np.ndarray | None
    lit: np.ndarray
    shadow: np.ndarray
    planet_umbra: np.ndarray
    planet_penumbra: np.ndarray
    umbra: np.ndarray
    antumbra: np.ndarray
    penumbra: np.ndarray

    def __len__(self) -> int:
        return len(self.t_in)


def _points(name, value) -> np.ndarray:
    """Return `value` as finite (N, 3) float64; a copy, so that later changes do not reach it."""
    allowed = "an array of shape (N, 3) or (3,) of finite numbers"
    try:
        points = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(name, value, allowed) from None
    if points.size == 0 and points.ndim <= 2:
        points = points.reshape(0, 3)
    if points.ndim == 1:
        points = points[None, :]
    if points.ndim != 2 or points.shape[1] != 3:
        raise ParameterError(name, points.shape, f"{allowed}; this is its shape")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        worst = int(np.argmax(bad))
        raise ParameterError(
            name, points[worst].tolist(), f"3 finite numbers in each ray (this is ray {worst})"
        )
    return points


def _limits(value, count) -> np.ndarray:
    """Return t_max as (count,) float64, inf where the caller set none."""
    if value is None:
        return np.full(count, np.inf)
    allowed = f"None, a number or ({count},) numbers, each >= 0 or inf"
    try:
        limits = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("t_max", value, allowed) from None
    if limits.ndim == 0:
        limits = np.full(count, float(limits))
    if limits.shape != (count,):
        raise ParameterError("t_max", limits.shape, f"{allowed}; this is its shape")
    bad = ~(limits >= 0)
    if bad.any():
        worst = int(np.argmax(bad))
        raise ParameterError("t_max", float(limits[worst]), f"{allowed} (this is ray {worst})")
    return limits
