"""Axes of the tables of multiple scattering: where their nodes lie, what they hold between them, and how they are read.

A table's values are those whose linear interpolation fits best, or finer steps of cubics through the nodes that were
solved. GPU twin: shaders/multiple.glsl, shaders/multiple_level.frag.
"""

import math

import numpy as np

from shadowatmo.harmonics import polar_basis
from shadowatmo.ray import safe_sqrt

SUN_WIDTH = 0.06  # of mu_s about the horizon that gets most texels
HIGHEST_SUN = 0.9999  # mu_s of the last texel: the azimuth from the sun must mean something
FINER = 4  # places of the level and of the ground's irradiance to a cell of the table over the sun
FINER_HEIGHTS = 2  # places of the level to a cell over the altitude
FIT = 8  # points to a cell by which lines are fitted
AEROSOLS_END = 8.0  # scale heights of aerosols that the table's altitudes reach


def sun_elevation(mu_s):
    """Return a stand-in for the sun's elevation: mu_s about the horizon, uniform in the angle about the zenith (2)."""
    return 2.0 * mu_s / (1.0 + safe_sqrt(1.0 - np.abs(mu_s)))


def sun_range(atmosphere) -> tuple[float, float]:
    """Return arcsinh(elevation / SUN_WIDTH) at the two ends of the sun's axis; the lowest sun leaves the sky dark."""
    dip = 2.2 * math.acos(atmosphere.bottom_radius / atmosphere.top_radius)
    ends = np.array([-math.sin(min(math.radians(85.0), dip)), HIGHEST_SUN])
    return tuple(np.arcsinh(sun_elevation(ends) / SUN_WIDTH).tolist())


def sun_coordinate(atmosphere, mu_s):
    """Return the place 0..1 of mu_s on the sun's axis."""
    low, high = sun_range(atmosphere)
    return np.clip((np.arcsinh(sun_elevation(mu_s) / SUN_WIDTH) - low) / (high - low), 0.0, 1.0)


def sun_height(atmosphere, unit):
    """Return mu_s at a place 0..1; the inverse of sun_coordinate."""
    low, high = sun_range(atmosphere)
    elevation = SUN_WIDTH * np.sinh(low + (high - low) * unit)
    return elevation - 0.25 * elevation * np.abs(elevation)


def height_coordinate(atmosphere, altitude):
    """Return the place 0..1 of an altitude [m]: its square root, which crowds the nodes at the ground."""
    return np.sqrt(np.clip(altitude / atmosphere.thickness, 0.0, 1.0))


def height_of(atmosphere, unit):
    """Return the altitude [m] at a place 0..1."""
    return atmosphere.thickness * unit * unit


def highest_layer(atmosphere) -> float:
    """Return the place 0..1 of the highest altitude of the aerosols' table."""
    return float(height_coordinate(atmosphere, AEROSOLS_END * atmosphere.mie_scale_height))


def layer_step(atmosphere, recipe) -> float:
    """Return how far the altitudes of the aerosols' table are apart, in steps of the field's."""
    return highest_layer(atmosphere) * (recipe.heights - 1) / (recipe.layers - 1)


def azimuth_cosine(mu, mu_s, nu):
    """Return the cosine of the azimuth from the sun of a direction at zenith cosine mu."""
    across = np.maximum((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 1e-12)
    return np.clip((nu - mu * mu_s) / np.sqrt(across), -1.0, 1.0)


def azimuth_coordinate(c):
    """Return the place 0..1 of an azimuth's cosine: the sine of its half, which crowds the nodes before the sun."""
    return np.sqrt(0.5 - 0.5 * c)


def azimuth_fit(count, degree):
    """Return what the table's azimuths hold of cos(m azimuth), (count, degree + 1)."""
    return broken_line(count, lambda unit: np.cos(np.outer(2.0 * np.arcsin(unit), np.arange(degree + 1))))


def polar_fit(count, degree):
    """Return what the table's zenith angles, from straight down up, hold of the polar basis (count, coefficients)."""
    return broken_line(count, lambda unit: polar_basis(-np.cos(np.pi * unit), degree))


def broken_line(count, function):
    """Return the values (count, ...) at places 0..1 whose linear interpolation is closest to a function, by squares.

    Values of the function itself would leave an error of one sign in every cell, and 2.4 times as much by squares.
    """
    unit = (np.arange(FIT * (count - 1)) + 0.5) / FIT
    hats = np.maximum(1.0 - np.abs(unit[:, None] - np.arange(count)), 0.0)
    return np.linalg.solve(hats.T @ hats, hats.T @ function(unit / (count - 1)))


def finer_suns(values):
    """Return values (..., suns, 3) at FINER places to a cell, by monotone cubics, where lines would show as bands."""
    return finer(values, FINER)


def finer_heights(values):
    """Return values (heights, suns, 3) at FINER_HEIGHTS places to a cell over the altitude."""
    return np.swapaxes(finer(np.swapaxes(values, 0, 1), FINER_HEIGHTS), 0, 1)


def finer(values, count):
    """Return values (..., N, 3) at `count` places to each of the N - 1 cells, by monotone cubics.

    The slope at a node is the harmonic mean of those beside it (Fritsch and Butland 1984), or 0 at an extremum.
    """
    steps = np.diff(values, axis=-2)
    before = np.concatenate([steps[..., :1, :], steps], axis=-2)
    after = np.concatenate([steps, steps[..., -1:, :]], axis=-2)
    product = before * after
    slopes = np.where(product > 0.0, 2.0 * product / np.where(product > 0.0, before + after, 1.0), 0.0)
    f = (np.arange(count) / count)[:, None]
    low, high = values[..., :-1, None, :], values[..., 1:, None, :]
    start, end = slopes[..., :-1, None, :], slopes[..., 1:, None, :]
    cubic = low + f * (start + f * (3.0 * (high - low) - 2.0 * start - end + f * (start + end - 2.0 * (high - low))))
    cells = cubic.reshape(*values.shape[:-2], -1, 3)
    return np.concatenate([cells, values[..., -1:, :]], axis=-2)


def interpolate(table, units):
    """Return a table (n1, n2, ..., 3) at places 0..1 along its axes, linear in each, shape (..., 3)."""
    corners = [(np.zeros(units[0].shape, np.intp), np.ones(units[0].shape))]
    for unit, size in zip(units, table.shape, strict=False):
        place = unit * (size - 1)
        cell = np.minimum(place.astype(np.intp), size - 2)
        part = place - cell
        corners = [(i * size + cell + k, w * f) for i, w in corners for k, f in ((0, 1.0 - part), (1, part))]
    flat = table.reshape(-1, table.shape[-1])
    return sum(w[..., None] * flat[i] for i, w in corners)
