"""Float64 twin of the solve of eclipse_multiple: lookups in a volume of ratios, and the gathers at its nodes.

Slow and plain; the shaders do the same in float32. See shadowatmo/eclipse_multiple.py for the method.
"""

from dataclasses import dataclass

import numpy as np

from shadowatmo.eclipse import visible_fraction
from shadowatmo.eclipse_multiple import RatioGrid, azimuth_harmonics, shade, zenith_harmonics
from shadowatmo.harmonics import band_coefficients, harmonic_indices, phase_moments, rayleigh_moments
from shadowatmo.medium import extinction, scattering
from shadowatmo.multiple import path_pieces, point_paths
from shadowatmo.multiple_axes import height_coordinate, interpolate, sun_coordinate
from shadowatmo.phase import rayleigh_phase
from shadowatmo.transmittance import columns_to_top


@dataclass(frozen=True, eq=False)
class RatioVolume:
    """What one moon leaves of multiple scattering: a grid, its sun and moon, and what `RatioGrid.values` gave.

    values : (tiles, heights, sectors, rings, 3)
    """

    grid: RatioGrid
    sun: object
    occluder: object
    values: np.ndarray

    def _visible(self, points):
        return visible_fraction(points.reshape(-1, 3), self.sun, self.occluder).reshape(points.shape[:-1])

    def _tile(self, tile, points):
        """Return a tile's values (..., 3) and the sides (...) at points (..., 3) [m]."""
        r = np.linalg.norm(points, axis=-1)
        ring, sector, side = self.grid.frame.place(points / r[..., None])
        atmosphere = self.grid.atmosphere
        height = height_coordinate(atmosphere, r - atmosphere.bottom_radius)
        return interpolate(self.values[tile], [height, sector, ring]), side

    def source(self, points, directions, source, mean, density):
        """Return the source (..., 3) under the moon from the one without, at points and in directions (..., 3).

        mean : mean radiance (..., 3) [1/sr]; density : (..., 2) of molecules and aerosols.
        """
        atmosphere, degree = self.grid.atmosphere, self.grid.recipe.degree
        up = points / np.linalg.norm(points, axis=-1, keepdims=True)
        turned = self.grid.frame.turn(up, directions)
        azimuth = np.arctan2(turned[..., 1], turned[..., 0])
        basis = zenith_harmonics(np.clip(turned[..., 2], -1.0, 1.0), degree)
        basis = basis * azimuth_harmonics(azimuth.ravel(), degree).reshape(basis.shape)
        degrees, m = harmonic_indices(degree)
        degrees = np.concatenate([degrees, degrees[m > 0]])
        lambdas = np.stack([rayleigh_moments(degree), phase_moments(atmosphere.mie_g, degree)])[:, degrees]
        beta = density[..., None] * scattering(atmosphere)
        change = np.zeros(points.shape)
        for tile in range(1, len(degrees)):
            value, side = self._tile(tile, points)
            sign = side if tile >= len(m) else np.ones_like(side)
            weight = np.einsum("...sc,s->...c", beta, lambdas[:, tile])
            change += (sign * basis[..., tile])[..., None] * weight * value
        ratio = shade(self._visible(points))[..., None] * np.exp(self._tile(0, points)[0])
        return np.minimum(ratio * np.maximum(source + np.sqrt(4.0 * np.pi) * mean * change, 0.0), source)

    def ground_ratio(self, points):
        """Return skylight at points of the ground (..., 3) [m] over that without the moon, (..., 3)."""
        r = np.linalg.norm(points, axis=-1, keepdims=True)
        ring, sector, _ = self.grid.frame.place(points / r)
        ratio = shade(self._visible(points))[..., None] * np.exp(interpolate(self.values[-1, 0], [sector, ring]))
        return np.minimum(ratio, 1.0)


class RatioGather:
    """All rays of one effort from the nodes of a grid, and what they see without the moon and with it."""

    def __init__(self, grid, sun, occluder, effort):
        self.grid, self.sun, self.occluder, self.effort = grid, sun, occluder, effort
        atmosphere, recipe = grid.atmosphere, grid.recipe
        self.shape = (recipe.heights, recipe.columns, effort.polar * effort.around)
        mu = np.broadcast_to(grid.polar(effort)[0][:, None, :, None], (*self.shape[:2], effort.polar, effort.around))
        azimuth = np.broadcast_to(grid.azimuths(effort), mu.shape).ravel()
        mu = mu.ravel()
        sine = np.sqrt(1.0 - mu * mu)
        up = np.broadcast_to(grid.up[None, :, None], (*self.shape, 3)).reshape(-1, 3)
        turned = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), mu], axis=-1)
        self.directions = grid.frame.turn_back(up, turned)
        altitude = np.broadcast_to(grid.altitude[:, None, None], self.shape).ravel()
        self.base = up * (atmosphere.bottom_radius + altitude)[:, None]
        mu_s, self.nu = up @ np.array(sun.direction), self.directions @ np.array(sun.direction)
        self.ray, sun_y, cuts, self.hits = point_paths(atmosphere, altitude, mu, mu_s, self.nu)
        self.pieces, columns = path_pieces(atmosphere, self.ray, sun_y, self.nu, cuts, effort.nodes, effort.nodes)
        self.transmittance = np.exp(-columns @ extinction(atmosphere))
        self.ground_sun = (sun_y + self.nu * cuts[:, 3]) / atmosphere.bottom_radius
        self.landing = self.base + cuts[:, 3:] * self.directions

    def _points(self, piece):
        """Return the nodes of a piece and the directions there, (P, n, 3)."""
        r = self.grid.atmosphere.bottom_radius + piece.altitude
        t = r * piece.mu - self.ray.x[piece.rays, None]
        directions = np.broadcast_to(self.directions[piece.rays, None], (*t.shape, 3))
        return self.base[piece.rays, None] + t[..., None] * directions, directions

    def _visible(self, points):
        return visible_fraction(points.reshape(-1, 3), self.sun, self.occluder).reshape(points.shape[:-1])

    def first(self):
        """Return single scattering and the sunlit ground, without and with the moon, (2, *shape, 3)."""
        atmosphere = self.grid.atmosphere
        phase = np.polynomial.legendre.legval(self.nu, band_coefficients(atmosphere.mie_g, self.grid.recipe.band))
        phases = np.stack([rayleigh_phase(self.nu), phase], axis=-1)
        radiance = np.zeros((2, len(self.nu), 3))
        for piece in self.pieces:
            source = np.einsum("pns,ps,sc->pnc", piece.density, phases[piece.rays], scattering(atmosphere))
            light = piece.weight * piece.light * source
            visible = self._visible(self._points(piece)[0])[..., None]
            radiance[:, piece.rays] += np.stack([light.sum(axis=1), (visible * light).sum(axis=1)])
        mu_s = np.maximum(self.ground_sun, 0.0)[:, None]
        sun = np.exp(
            -columns_to_top(atmosphere, np.zeros(len(mu_s)), mu_s[:, 0] * atmosphere.bottom_radius)
            @ extinction(atmosphere)
        )
        return self._with_ground(radiance, mu_s * sun, self._visible(self.landing)[:, None])

    def following(self, table, volume):
        """Return what the source of a MultipleTable sends, without and with the moon as far as a volume knows it."""
        atmosphere = self.grid.atmosphere
        radiance = np.zeros((2, len(self.nu), 3))
        for piece in self.pieces:
            nu = np.broadcast_to(self.nu[piece.rays, None], piece.mu.shape)
            source = table.source(piece.altitude, piece.mu_s, piece.mu, nu)
            units = [height_coordinate(atmosphere, piece.altitude), sun_coordinate(atmosphere, piece.mu_s)]
            mean = np.exp(interpolate(table.level, units))
            with_moon = volume.source(*self._points(piece), source, mean, piece.density)
            for field, value in zip(radiance, (source, with_moon), strict=True):
                field[piece.rays] += piece.gain * np.sum(piece.weight * value, axis=1)
        return self._with_ground(radiance, table.ground_irradiance(self.ground_sun), volume.ground_ratio(self.landing))

    def _with_ground(self, radiance, irradiance, ratio):
        albedo = np.array(self.grid.atmosphere.ground_albedo)
        reflected = self.hits[:, None] * self.transmittance * albedo / np.pi * irradiance
        return (radiance + np.stack([reflected, reflected * ratio])).reshape(2, *self.shape, 3)


def solve_ratio(table, sun, occluder, recipe) -> RatioVolume:
    """Return the volume of one moon over a MultipleTable of the same air."""
    grid = RatioGrid(table.atmosphere, sun, occluder, recipe)
    gather = RatioGather(grid, sun, occluder, recipe.first)
    first = np.stack([grid.moments(field, recipe.first) for field in gather.first()])
    volume = RatioVolume(grid, sun, occluder, grid.values(*first))
    gather = RatioGather(grid, sun, occluder, recipe.later)
    for _ in range(recipe.iterations):
        following = [grid.moments(field, recipe.later) for field in gather.following(table, volume)]
        volume = RatioVolume(grid, sun, occluder, grid.values(*(first + np.stack(following))))
    return volume
